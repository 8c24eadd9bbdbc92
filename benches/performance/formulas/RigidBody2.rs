// Written by `cargo bench -p leafwise-benches --bench performance -- formulas`.
pub struct RigidBody2 { full: [f64; 10], residual: [f64; 4] }
impl RigidBody2 {
pub fn new(parameters: &[f64; 3], epsilon: f64, h: f64) -> Self {
let full = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = epsilon; let s4 = h; let s5 = 1.0_f64;
let s6 = 3.141592653589793_f64; let s7 = 2.0_f64; let s18 = s5 / s0; let s18 = s4 * s18; let s8 = s3 * s18; let s18 = s5 / s1;
let s18 = s4 * s18; let s9 = s3 * s18; let s18 = s5 / s2; let s18 = s4 * s18; let s10 = s3 * s18; let s18 = s8 * s8;
let s12 = s18 * s7; let s13 = s8 - s10; let s14 = s8 - s9; let s15 = s9 - s10; let s18 = s9 * s9; let s16 = s18 * s7;
let s18 = s10 * s10; let s17 = s18 * s7;
[
s8, s9, s10, s6, s12, s13, s14, s15, s16, s17, ]
};
let residual = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = epsilon; let s4 = h; let s5 = 1.0_f64;
let s6 = 3.141592653589793_f64; let s11 = s5 / s0; let s11 = s4 * s11; let s7 = s3 * s11; let s11 = s5 / s1; let s11 = s4 * s11;
let s8 = s3 * s11; let s11 = s5 / s2; let s11 = s4 * s11; let s9 = s3 * s11;
[
s7, s8, s9, s6, ]
};
Self { full, residual }
}
}
impl Formulas<3> for RigidBody2 {
const MOST_CHORDS: u32 = 1;
#[inline(always)]
fn residual(&self, y: &[f64; 3]) -> Residual<3> {
let c = &self.residual;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = 0.5_f64; let s8 = 1.998046875_f64; let s24 = s1 * s4; let s25 = s2 * s5; let s26 = s1 * s25;
let s27 = s2 * s24; let s27 = s26 - s27; let s26 = s27 * s7; let s28 = s0 * s3; let s29 = s2 * s28; let s30 = s0 * s25;
let s30 = s29 - s30; let s29 = s0 * s24; let s31 = s1 * s28; let s31 = s29 - s31; let s29 = s28 * s28; let s32 = s24 * s24;
let s33 = s25 * s25; let s32 = s29 + s32; let s33 = s32 + s33; let s32 = COTANGENT.derivative(0, s33); let s29 = s25 * s30; let s34 = s24 * s31;
let s34 = s29 - s34; let s34 = s32 * s34; let s12 = s26 + s34; let s34 = s30 * s7; let s26 = s28 * s31; let s25 = s25 * s27;
let s25 = s26 - s25; let s25 = s32 * s25; let s13 = s34 + s25; let s25 = s31 * s7; let s24 = s24 * s27; let s28 = s28 * s30;
let s28 = s24 - s28; let s28 = s32 * s28; let s14 = s25 + s28; let s15 = -s27; let s16 = -s30; let s17 = -s31;
let s18 = s6 * s8; let s21 = libm::sqrt(s33);
Residual { base: [s0, s1, s2], offset: [s12, s13, s14], increment: [s15, s16, s17], guard: [[s18, s18, s18], [s21, s21, s21]] }
}
#[inline(always)]
fn full(&self, y: &[f64; 3]) -> Full<3> {
let c = &self.full;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = c[4]; let s8 = c[5]; let s9 = c[6]; let s10 = c[7]; let s11 = c[8];
let s12 = c[9]; let s13 = 0.5_f64; let s14 = 1.0_f64; let s15 = 0.0_f64; let s16 = 1.998046875_f64; let s50 = s1 * s4;
let s51 = s2 * s5; let s52 = s1 * s51; let s53 = s2 * s50; let s53 = s52 - s53; let s52 = s53 * s13; let s54 = s0 * s3;
let s55 = s2 * s54; let s56 = s0 * s51; let s56 = s55 - s56; let s55 = s0 * s50; let s57 = s1 * s54; let s57 = s55 - s57;
let s55 = s54 * s54; let s58 = s50 * s50; let s59 = s51 * s51; let s58 = s55 + s58; let s59 = s58 + s59; let s58 = COTANGENT.derivative(0, s59);
let s55 = s51 * s56; let s60 = s50 * s57; let s60 = s55 - s60; let s55 = s58 * s60; let s20 = s52 + s55; let s55 = s56 * s13;
let s52 = s54 * s57; let s61 = s51 * s53; let s61 = s52 - s61; let s52 = s58 * s61; let s21 = s55 + s52; let s52 = s57 * s13;
let s55 = s50 * s53; let s62 = s54 * s56; let s62 = s55 - s62; let s55 = s58 * s62; let s22 = s52 + s55; let s23 = -s53;
let s24 = -s56; let s25 = -s57; let s55 = s0 * s7; let s52 = COTANGENT.derivative(1, s59); let s55 = s55 * s52; let s63 = s2 * s8;
let s64 = s51 * s63; let s41 = s1 * s9; let s65 = s50 * s41; let s66 = s60 * s55; let s65 = s64 + s65; let s65 = s58 * s65;
let s66 = s14 + s66; let s26 = s66 + s65; let s36 = s2 * s10; let s65 = s36 * s13; let s66 = s1 * s11; let s66 = s52 * s66;
let s64 = s60 * s66; let s42 = s0 * s9; let s67 = s4 * s57; let s68 = s50 * s42; let s68 = s67 - s68; let s68 = s58 * s68;
let s65 = s64 - s65; let s27 = s65 - s68; let s37 = s1 * s10; let s68 = s37 * s13; let s65 = s2 * s12; let s65 = s52 * s65;
let s60 = s60 * s65; let s52 = s0 * s8; let s64 = s5 * s56; let s67 = s51 * s52; let s67 = s64 + s67; let s67 = s58 * s67;
let s68 = s60 - s68; let s28 = s68 + s67; let s67 = s63 * s13; let s68 = s61 * s55; let s57 = s3 * s57; let s60 = s54 * s41;
let s60 = s57 - s60; let s60 = s58 * s60; let s68 = s67 + s68; let s29 = s68 + s60; let s60 = s54 * s42; let s68 = s51 * s36;
let s67 = s61 * s66; let s68 = s60 - s68; let s68 = s58 * s68; let s67 = s14 + s67; let s30 = s67 - s68; let s68 = s52 * s13;
let s61 = s61 * s65; let s67 = s5 * s53; let s51 = s51 * s37; let s51 = s67 - s51; let s51 = s58 * s51; let s61 = s68 + s61;
let s31 = s61 - s51; let s51 = s41 * s13; let s55 = s62 * s55; let s56 = s3 * s56; let s61 = s54 * s63; let s61 = s56 + s61;
let s61 = s58 * s61; let s51 = s55 - s51; let s32 = s51 - s61; let s61 = s42 * s13; let s66 = s62 * s66; let s53 = s4 * s53;
let s51 = s50 * s36; let s51 = s53 - s51; let s51 = s58 * s51; let s61 = s66 - s61; let s33 = s61 + s51; let s50 = s50 * s37;
let s54 = s54 * s52; let s65 = s62 * s65; let s54 = s50 + s54; let s54 = s58 * s54; let s65 = s14 + s65; let s34 = s65 - s54;
let s38 = -s63; let s40 = -s52; let s44 = s6 * s16; let s47 = libm::sqrt(s59);
Full { residual: Residual { base: [s0, s1, s2], offset: [s20, s21, s22], increment: [s23, s24, s25], guard: [[s44, s44, s44], [s47, s47, s47]] }, target: [[s26, s27, s28], [s29, s30, s31], [s32, s33, s34]], change: [[s15, s36, s37], [s38, s15, s40], [s41, s42, s15]] }
}
}
