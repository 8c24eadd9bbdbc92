// Written by `cargo bench -p leafwise-benches --bench performance -- formulas`.
pub struct RigidBody2 { full: [f64; 10], residual: [f64; 4] }
impl RigidBody2 {
pub fn new(parameters: &[f64; 3], epsilon: f64, h: f64) -> Self {
let full = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = epsilon; let s4 = h; let s5 = 1.0_f64;
let s6 = 3.141592653589793_f64; let s7 = 2.0_f64; let s8 = s5 / s0; let s8 = s4 * s8; let s8 = s3 * s8; let s9 = s5 / s1;
let s9 = s4 * s9; let s9 = s3 * s9; let s10 = s5 / s2; let s10 = s4 * s10; let s10 = s3 * s10; let s11 = s8 * s8;
let s11 = s11 * s7; let s12 = s8 - s10; let s13 = s8 - s9; let s14 = s9 - s10; let s15 = s9 * s9; let s15 = s15 * s7;
let s16 = s10 * s10; let s16 = s16 * s7;
[
s8, s9, s10, s6, s11, s12, s13, s14, s15, s16, ]
};
let residual = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = epsilon; let s4 = h; let s5 = 1.0_f64;
let s6 = 3.141592653589793_f64; let s7 = s5 / s0; let s7 = s4 * s7; let s7 = s3 * s7; let s8 = s5 / s1; let s8 = s4 * s8;
let s8 = s3 * s8; let s9 = s5 / s2; let s9 = s4 * s9; let s9 = s3 * s9;
[
s7, s8, s9, s6, ]
};
Self { full, residual }
}
}
impl Formulas<3> for RigidBody2 {
const MOST_CHORDS: u32 = 2;
#[inline(always)]
fn residual(&self, y: &[f64; 3]) -> Residual<3> {
let c = &self.residual;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = 0.5_f64; let s8 = 1.998046875_f64; let s9 = s1 * s4; let s10 = s2 * s5; let s11 = s1 * s10;
let s12 = s2 * s9; let s12 = s11 - s12; let s11 = s12 * s7; let s13 = s0 * s3; let s14 = s2 * s13; let s15 = s0 * s10;
let s15 = s14 - s15; let s14 = s0 * s9; let s16 = s1 * s13; let s16 = s14 - s16; let s14 = s13 * s13; let s17 = s9 * s9;
let s18 = s10 * s10; let s17 = s14 + s17; let s18 = s17 + s18; let s17 = COTANGENT.derivative(0, s18); let s14 = s10 * s15; let s19 = s9 * s16;
let s19 = s14 - s19; let s19 = s17 * s19; let s19 = s11 + s19; let s11 = s15 * s7; let s14 = s13 * s16; let s10 = s10 * s12;
let s10 = s14 - s10; let s10 = s17 * s10; let s10 = s11 + s10; let s11 = s16 * s7; let s9 = s9 * s12; let s13 = s13 * s15;
let s13 = s9 - s13; let s13 = s17 * s13; let s13 = s11 + s13; let s12 = -s12; let s15 = -s15; let s16 = -s16;
let s11 = s6 * s8; let s18 = libm::sqrt(s18);
Residual { base: [s0, s1, s2], offset: [s19, s10, s13], increment: [s12, s15, s16], guard: [[s11, s11, s11], [s18, s18, s18]] }
}
#[inline(always)]
fn full(&self, y: &[f64; 3]) -> Full<3> {
let c = &self.full;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = c[4]; let s8 = c[5]; let s9 = c[6]; let s10 = c[7]; let s11 = c[8];
let s12 = c[9]; let s13 = 0.5_f64; let s14 = 1.0_f64; let s15 = 0.0_f64; let s16 = 1.998046875_f64; let s17 = s1 * s4;
let s18 = s2 * s5; let s19 = s1 * s18; let s20 = s2 * s17; let s20 = s19 - s20; let s19 = s20 * s13; let s21 = s0 * s3;
let s22 = s2 * s21; let s23 = s0 * s18; let s23 = s22 - s23; let s22 = s0 * s17; let s24 = s1 * s21; let s24 = s22 - s24;
let s22 = s21 * s21; let s25 = s17 * s17; let s26 = s18 * s18; let s25 = s22 + s25; let s26 = s25 + s26; let s25 = COTANGENT.derivative(0, s26);
let s22 = s18 * s23; let s27 = s17 * s24; let s27 = s22 - s27; let s22 = s25 * s27; let s22 = s19 + s22; let s19 = s23 * s13;
let s28 = s21 * s24; let s29 = s18 * s20; let s29 = s28 - s29; let s28 = s25 * s29; let s28 = s19 + s28; let s19 = s24 * s13;
let s30 = s17 * s20; let s31 = s21 * s23; let s31 = s30 - s31; let s30 = s25 * s31; let s30 = s19 + s30; let s19 = -s20;
let s32 = -s23; let s33 = -s24; let s34 = s0 * s7; let s35 = COTANGENT.derivative(1, s26); let s34 = s34 * s35; let s36 = s2 * s8;
let s37 = s18 * s36; let s38 = s1 * s9; let s39 = s17 * s38; let s40 = s27 * s34; let s39 = s37 + s39; let s39 = s25 * s39;
let s40 = s14 + s40; let s39 = s40 + s39; let s40 = s2 * s10; let s37 = s40 * s13; let s41 = s1 * s11; let s41 = s35 * s41;
let s42 = s27 * s41; let s43 = s0 * s9; let s44 = s4 * s24; let s45 = s17 * s43; let s45 = s44 - s45; let s45 = s25 * s45;
let s37 = s42 - s37; let s45 = s37 - s45; let s37 = s1 * s10; let s42 = s37 * s13; let s44 = s2 * s12; let s44 = s35 * s44;
let s27 = s27 * s44; let s35 = s0 * s8; let s46 = s5 * s23; let s47 = s18 * s35; let s47 = s46 + s47; let s47 = s25 * s47;
let s42 = s27 - s42; let s47 = s42 + s47; let s42 = s36 * s13; let s27 = s29 * s34; let s24 = s3 * s24; let s46 = s21 * s38;
let s46 = s24 - s46; let s46 = s25 * s46; let s27 = s42 + s27; let s46 = s27 + s46; let s27 = s21 * s43; let s42 = s18 * s40;
let s24 = s29 * s41; let s42 = s27 - s42; let s42 = s25 * s42; let s24 = s14 + s24; let s42 = s24 - s42; let s24 = s35 * s13;
let s29 = s29 * s44; let s27 = s5 * s20; let s18 = s18 * s37; let s18 = s27 - s18; let s18 = s25 * s18; let s29 = s24 + s29;
let s18 = s29 - s18; let s29 = s38 * s13; let s34 = s31 * s34; let s23 = s3 * s23; let s24 = s21 * s36; let s24 = s23 + s24;
let s24 = s25 * s24; let s29 = s34 - s29; let s24 = s29 - s24; let s29 = s43 * s13; let s41 = s31 * s41; let s20 = s4 * s20;
let s34 = s17 * s40; let s34 = s20 - s34; let s34 = s25 * s34; let s29 = s41 - s29; let s34 = s29 + s34; let s17 = s17 * s37;
let s21 = s21 * s35; let s44 = s31 * s44; let s21 = s17 + s21; let s21 = s25 * s21; let s44 = s14 + s44; let s21 = s44 - s21;
let s36 = -s36; let s35 = -s35; let s44 = s6 * s16; let s26 = libm::sqrt(s26);
Full { residual: Residual { base: [s0, s1, s2], offset: [s22, s28, s30], increment: [s19, s32, s33], guard: [[s44, s44, s44], [s26, s26, s26]] }, target: [[s39, s45, s47], [s46, s42, s18], [s24, s34, s21]], change: [[s15, s40, s37], [s36, s15, s35], [s38, s43, s15]] }
}
}
