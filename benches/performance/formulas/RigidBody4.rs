// Written by `cargo bench -p leafwise-benches --bench performance -- formulas`.
pub struct RigidBody4 { full: [f64; 11], residual: [f64; 8] }
impl RigidBody4 {
pub fn new(parameters: &[f64; 3], epsilon: f64, h: f64) -> Self {
let full = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = epsilon; let s4 = h; let s5 = 1.0_f64;
let s6 = 2.0_f64; let s7 = 0.08333333333333333_f64; let s8 = 3.141592653589793_f64; let s9 = 0.16666666666666666_f64; let s10 = s5 / s0; let s11 = s4 * s10;
let s12 = s5 / s1; let s13 = s4 * s12; let s14 = s5 / s2; let s15 = s4 * s14; let s16 = s3 * s4; let s16 = s16 * s16;
let s16 = s4 * s16; let s17 = s0 * s0; let s17 = s5 / s17; let s18 = s17 * s14; let s19 = s10 * s12; let s19 = s14 * s19;
let s20 = s1 * s1; let s20 = s5 / s20; let s14 = s14 * s20; let s21 = s19 * s6; let s14 = s18 + s14; let s21 = s14 - s21;
let s21 = s16 * s21; let s14 = s21 * s7; let s17 = s17 * s12; let s18 = s2 * s2; let s18 = s5 / s18; let s12 = s12 * s18;
let s22 = s19 * s6; let s17 = s22 - s17; let s12 = s17 - s12; let s12 = s16 * s12; let s17 = s12 * s7; let s20 = s10 * s20;
let s18 = s10 * s18; let s19 = s19 * s6; let s20 = s19 - s20; let s18 = s20 - s18; let s18 = s16 * s18; let s16 = s18 * s7;
let s12 = s12 * s9; let s21 = s21 * s9; let s18 = s18 * s9;
[
s3, s11, s13, s15, s14, s17, s16, s8, s12, s21, s18, ]
};
let residual = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = epsilon; let s4 = h; let s5 = 1.0_f64;
let s6 = 2.0_f64; let s7 = 0.08333333333333333_f64; let s8 = 3.141592653589793_f64; let s9 = s5 / s0; let s10 = s4 * s9; let s11 = s5 / s1;
let s12 = s4 * s11; let s13 = s5 / s2; let s14 = s4 * s13; let s15 = s3 * s4; let s15 = s15 * s15; let s15 = s4 * s15;
let s16 = s0 * s0; let s16 = s5 / s16; let s17 = s16 * s13; let s18 = s9 * s11; let s18 = s13 * s18; let s19 = s1 * s1;
let s19 = s5 / s19; let s13 = s13 * s19; let s20 = s18 * s6; let s13 = s17 + s13; let s20 = s13 - s20; let s20 = s15 * s20;
let s20 = s20 * s7; let s16 = s16 * s11; let s13 = s2 * s2; let s13 = s5 / s13; let s11 = s11 * s13; let s17 = s18 * s6;
let s16 = s17 - s16; let s11 = s16 - s11; let s11 = s15 * s11; let s11 = s11 * s7; let s19 = s9 * s19; let s13 = s9 * s13;
let s18 = s18 * s6; let s19 = s18 - s19; let s13 = s19 - s13; let s13 = s15 * s13; let s13 = s13 * s7;
[
s3, s10, s12, s14, s20, s11, s13, s8, ]
};
Self { full, residual }
}
}
impl Formulas<3> for RigidBody4 {
const MOST_CHORDS: u32 = 3;
#[inline(always)]
fn residual(&self, y: &[f64; 3]) -> Residual<3> {
let c = &self.residual;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = c[4]; let s8 = c[5]; let s9 = c[6]; let s10 = c[7]; let s11 = 0.5_f64;
let s12 = 1.998046875_f64; let s13 = s1 * s1; let s14 = s2 * s2; let s15 = s0 * s0; let s16 = s7 * s15; let s17 = s14 * s9;
let s16 = s5 + s16; let s17 = s16 - s17; let s17 = s1 * s17; let s15 = s8 * s15; let s16 = s13 * s9; let s15 = s6 - s15;
let s16 = s15 - s16; let s16 = s2 * s16; let s17 = s3 * s17; let s16 = s3 * s16; let s15 = s1 * s16; let s18 = s2 * s17;
let s18 = s15 - s18; let s15 = s18 * s11; let s13 = s13 * s7; let s14 = s14 * s8; let s13 = s4 + s13; let s14 = s13 - s14;
let s14 = s0 * s14; let s14 = s3 * s14; let s13 = s2 * s14; let s19 = s0 * s16; let s19 = s13 - s19; let s13 = s0 * s17;
let s20 = s1 * s14; let s20 = s13 - s20; let s13 = s14 * s14; let s21 = s17 * s17; let s22 = s16 * s16; let s21 = s13 + s21;
let s22 = s21 + s22; let s21 = COTANGENT.derivative(0, s22); let s13 = s16 * s19; let s23 = s17 * s20; let s23 = s13 - s23; let s23 = s21 * s23;
let s23 = s15 + s23; let s15 = s19 * s11; let s13 = s14 * s20; let s16 = s16 * s18; let s16 = s13 - s16; let s16 = s21 * s16;
let s16 = s15 + s16; let s15 = s20 * s11; let s17 = s17 * s18; let s14 = s14 * s19; let s14 = s17 - s14; let s14 = s21 * s14;
let s14 = s15 + s14; let s18 = -s18; let s19 = -s19; let s20 = -s20; let s15 = s10 * s12; let s22 = libm::sqrt(s22);
Residual { base: [s0, s1, s2], offset: [s23, s16, s14], increment: [s18, s19, s20], guard: [[s15, s15, s15], [s22, s22, s22]] }
}
#[inline(always)]
fn full(&self, y: &[f64; 3]) -> Full<3> {
let c = &self.full;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = c[4]; let s8 = c[5]; let s9 = c[6]; let s10 = c[7]; let s11 = c[8];
let s12 = c[9]; let s13 = c[10]; let s14 = 0.5_f64; let s15 = 1.0_f64; let s16 = 2.0_f64; let s17 = 1.998046875_f64;
let s18 = s1 * s1; let s19 = s2 * s2; let s20 = s0 * s0; let s21 = s7 * s20; let s22 = s19 * s9; let s21 = s5 + s21;
let s22 = s21 - s22; let s21 = s1 * s22; let s20 = s8 * s20; let s23 = s18 * s9; let s20 = s6 - s20; let s23 = s20 - s23;
let s20 = s2 * s23; let s21 = s3 * s21; let s20 = s3 * s20; let s24 = s1 * s20; let s25 = s2 * s21; let s25 = s24 - s25;
let s24 = s25 * s14; let s18 = s18 * s7; let s19 = s19 * s8; let s18 = s4 + s18; let s19 = s18 - s19; let s18 = s0 * s19;
let s18 = s3 * s18; let s26 = s2 * s18; let s27 = s0 * s20; let s27 = s26 - s27; let s26 = s0 * s21; let s28 = s1 * s18;
let s28 = s26 - s28; let s26 = s18 * s18; let s29 = s21 * s21; let s30 = s20 * s20; let s29 = s26 + s29; let s30 = s29 + s30;
let s29 = COTANGENT.derivative(0, s30); let s26 = s20 * s27; let s31 = s21 * s28; let s31 = s26 - s31; let s26 = s29 * s31; let s26 = s24 + s26;
let s24 = s27 * s14; let s32 = s18 * s28; let s33 = s20 * s25; let s33 = s32 - s33; let s32 = s29 * s33; let s32 = s24 + s32;
let s24 = s28 * s14; let s34 = s21 * s25; let s35 = s18 * s27; let s35 = s34 - s35; let s34 = s29 * s35; let s34 = s24 + s34;
let s24 = -s25; let s36 = -s27; let s37 = -s28; let s38 = s0 * s11; let s38 = s2 * s38; let s38 = s3 * s38;
let s39 = s1 * s38; let s40 = s0 * s12; let s40 = s1 * s40; let s40 = s3 * s40; let s41 = s2 * s40; let s41 = s39 + s41;
let s39 = s41 * s14; let s19 = s3 * s19; let s42 = s18 * s19; let s43 = s21 * s40; let s44 = s20 * s38; let s45 = COTANGENT.derivative(1, s30);
let s43 = s42 + s43; let s44 = s43 - s44; let s44 = s44 * s45; let s43 = s31 * s44; let s43 = s43 * s16; let s42 = s2 * s19;
let s46 = s0 * s38; let s42 = s42 - s20; let s46 = s42 + s46; let s42 = s27 * s38; let s47 = s20 * s46; let s48 = s0 * s40;
let s49 = s1 * s19; let s48 = s21 + s48; let s49 = s48 - s49; let s48 = s28 * s40; let s50 = s21 * s49; let s47 = s42 - s47;
let s48 = s47 + s48; let s50 = s48 + s50; let s50 = s29 * s50; let s39 = s15 - s39; let s43 = s39 + s43; let s50 = s43 - s50;
let s43 = s1 * s13; let s43 = s2 * s43; let s43 = s3 * s43; let s39 = s1 * s43; let s22 = s3 * s22; let s48 = s2 * s22;
let s39 = s20 - s39; let s48 = s39 - s48; let s39 = s48 * s14; let s47 = s1 * s12; let s47 = s0 * s47; let s47 = s3 * s47;
let s42 = s18 * s47; let s51 = s21 * s22; let s52 = s20 * s43; let s51 = s42 + s51; let s52 = s51 - s52; let s52 = s45 * s52;
let s51 = s31 * s52; let s51 = s51 * s16; let s42 = s2 * s47; let s53 = s0 * s43; let s53 = s42 + s53; let s42 = s27 * s43;
let s54 = s20 * s53; let s55 = s0 * s22; let s56 = s1 * s47; let s55 = s55 - s18; let s56 = s55 - s56; let s55 = s28 * s22;
let s57 = s21 * s56; let s54 = s42 - s54; let s55 = s54 + s55; let s57 = s55 + s57; let s57 = s29 * s57; let s51 = s39 + s51;
let s57 = s51 - s57; let s23 = s3 * s23; let s51 = s1 * s23; let s39 = s2 * s13; let s39 = s1 * s39; let s39 = s3 * s39;
let s55 = s2 * s39; let s51 = s51 - s21; let s55 = s51 + s55; let s51 = s55 * s14; let s54 = s2 * s11; let s54 = s0 * s54;
let s54 = s3 * s54; let s42 = s18 * s54; let s58 = s21 * s39; let s59 = s20 * s23; let s58 = s42 + s58; let s59 = s58 - s59;
let s59 = s45 * s59; let s31 = s31 * s59; let s31 = s31 * s16; let s45 = s2 * s54; let s58 = s0 * s23; let s45 = s18 - s45;
let s58 = s45 - s58; let s45 = s27 * s23; let s42 = s20 * s58; let s60 = s0 * s39; let s61 = s1 * s54; let s61 = s60 - s61;
let s60 = s28 * s39; let s62 = s21 * s61; let s42 = s45 + s42; let s60 = s42 + s60; let s62 = s60 + s62; let s62 = s29 * s62;
let s31 = s51 - s31; let s62 = s31 + s62; let s31 = s46 * s14; let s51 = s33 * s44; let s51 = s51 * s16; let s60 = s28 * s19;
let s42 = s18 * s49; let s38 = s25 * s38; let s45 = s20 * s41; let s42 = s60 + s42; let s38 = s42 + s38; let s45 = s38 + s45;
let s45 = s29 * s45; let s51 = s31 + s51; let s45 = s51 + s45; let s51 = s53 * s14; let s31 = s33 * s52; let s31 = s31 * s16;
let s38 = s28 * s47; let s42 = s18 * s56; let s43 = s25 * s43; let s60 = s20 * s48; let s42 = s38 + s42; let s43 = s42 + s43;
let s60 = s43 - s60; let s60 = s29 * s60; let s51 = s15 + s51; let s31 = s51 + s31; let s60 = s31 + s60; let s31 = s58 * s14;
let s33 = s33 * s59; let s33 = s33 * s16; let s28 = s28 * s54; let s51 = s18 * s61; let s23 = s25 * s23; let s20 = s20 * s55;
let s51 = s28 + s51; let s23 = s51 + s23; let s20 = s23 + s20; let s20 = s29 * s20; let s33 = s31 - s33; let s20 = s33 - s20;
let s33 = s49 * s14; let s44 = s35 * s44; let s44 = s44 * s16; let s40 = s25 * s40; let s31 = s21 * s41; let s19 = s27 * s19;
let s23 = s18 * s46; let s31 = s40 - s31; let s19 = s31 - s19; let s23 = s19 - s23; let s23 = s29 * s23; let s44 = s33 + s44;
let s23 = s44 + s23; let s44 = s56 * s14; let s52 = s35 * s52; let s52 = s52 * s16; let s22 = s25 * s22; let s33 = s21 * s48;
let s47 = s27 * s47; let s19 = s18 * s53; let s33 = s22 + s33; let s47 = s33 - s47; let s19 = s47 - s19; let s19 = s29 * s19;
let s52 = s44 + s52; let s19 = s52 + s19; let s52 = s61 * s14; let s59 = s35 * s59; let s59 = s59 * s16; let s39 = s25 * s39;
let s21 = s21 * s55; let s54 = s27 * s54; let s18 = s18 * s58; let s21 = s39 - s21; let s54 = s21 - s54; let s18 = s54 + s18;
let s18 = s29 * s18; let s52 = s15 - s52; let s59 = s52 - s59; let s18 = s59 - s18; let s48 = -s48; let s55 = -s55;
let s46 = -s46; let s53 = -s53; let s58 = -s58; let s49 = -s49; let s56 = -s56; let s59 = s10 * s17;
let s30 = libm::sqrt(s30);
Full { residual: Residual { base: [s0, s1, s2], offset: [s26, s32, s34], increment: [s24, s36, s37], guard: [[s59, s59, s59], [s30, s30, s30]] }, target: [[s50, s57, s62], [s45, s60, s20], [s23, s19, s18]], change: [[s41, s48, s55], [s46, s53, s58], [s49, s56, s61]] }
}
}
