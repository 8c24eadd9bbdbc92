// Written by `cargo bench -p leafwise-benches --bench performance -- formulas`.
pub struct LotkaVolterra2 { full: [f64; 9], residual: [f64; 9] }
impl LotkaVolterra2 {
pub fn new(parameters: &[f64; 5], epsilon: f64, h: f64) -> Self {
let full = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = parameters[3]; let s4 = parameters[4]; let s5 = epsilon;
let s6 = h; let s7 = 0.25_f64; let s9 = s6 * s3; let s10 = s6 * s0; let s11 = s6 * s4; let s17 = s5 * s2;
let s12 = s17 * s7; let s18 = s1 * s2; let s18 = s5 * s18; let s13 = s18 * s7; let s19 = s1 * s0; let s19 = s6 * s19;
let s17 = s19 * s17; let s14 = s17 * s7; let s15 = s5 * s7; let s18 = s19 * s18; let s16 = s18 * s7;
[
s6, s9, s10, s11, s12, s13, s14, s15, s16, ]
};
let residual = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = parameters[3]; let s4 = parameters[4]; let s5 = epsilon;
let s6 = h; let s7 = 0.25_f64; let s9 = s6 * s3; let s10 = s6 * s0; let s11 = s6 * s4; let s17 = s5 * s2;
let s12 = s17 * s7; let s18 = s1 * s2; let s18 = s5 * s18; let s13 = s18 * s7; let s19 = s1 * s0; let s19 = s6 * s19;
let s17 = s19 * s17; let s14 = s17 * s7; let s15 = s5 * s7; let s18 = s19 * s18; let s16 = s18 * s7;
[
s6, s9, s10, s11, s12, s13, s14, s15, s16, ]
};
Self { full, residual }
}
}
impl Formulas<3> for LotkaVolterra2 {
const MOST_CHORDS: u32 = 1;
#[inline(always)]
fn residual(&self, y: &[f64; 3]) -> Residual<3> {
let c = &self.residual;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = c[4]; let s8 = c[5]; let s9 = c[6]; let s10 = c[7]; let s11 = c[8];
let s12 = 1.0_f64; let s13 = 2.0_f64; let s14 = -4.0_f64; let s24 = s12 / s1; let s25 = s1 * s3; let s25 = s4 + s25;
let s25 = s24 * s25; let s24 = s12 / s2; let s26 = s2 * s5; let s26 = s6 + s26; let s26 = s24 * s26; let s25 = s1 * s25;
let s26 = s2 * s26; let s24 = s25 * s7; let s27 = s26 * s8; let s27 = s24 - s27; let s24 = libm::sinh(s27); let s27 = libm::cosh(s27);
let s28 = s0 * s24; let s27 = s27 * s28; let s28 = s24 * s28; let s28 = s27 + s28; let s18 = s28 * s13; let s28 = s0 * s9;
let s26 = s26 * s10; let s28 = s26 - s28; let s26 = libm::sinh(s28); let s28 = libm::cosh(s28); let s24 = s1 * s26; let s28 = s28 * s24;
let s24 = s26 * s24; let s24 = s28 + s24; let s19 = s24 * s13; let s24 = s0 * s11; let s25 = s25 * s10; let s24 = s25 - s24;
let s25 = libm::sinh(s24); let s24 = libm::cosh(s24); let s26 = s2 * s25; let s24 = s24 * s26; let s26 = s25 * s26; let s26 = s24 + s26;
let s20 = s26 * s13; let s21 = s27 * s14; let s22 = s28 * s14; let s23 = s24 * s14;
Residual { base: [s0, s1, s2], offset: [s18, s19, s20], increment: [s21, s22, s23], guard: [[0.0; 3]; 2] }
}
#[inline(always)]
fn full(&self, y: &[f64; 3]) -> Full<3> {
let c = &self.full;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = c[4]; let s8 = c[5]; let s9 = c[6]; let s10 = c[7]; let s11 = c[8];
let s12 = 1.0_f64; let s13 = 2.0_f64; let s14 = -4.0_f64; let s15 = 4.0_f64; let s43 = s12 / s1; let s44 = s1 * s3;
let s44 = s4 + s44; let s45 = s43 * s44; let s46 = s12 / s2; let s47 = s2 * s5; let s47 = s6 + s47; let s48 = s46 * s47;
let s49 = s1 * s45; let s50 = s2 * s48; let s51 = s49 * s7; let s52 = s50 * s8; let s52 = s51 - s52; let s51 = libm::sinh(s52);
let s52 = libm::cosh(s52); let s53 = s0 * s51; let s54 = s52 * s53; let s55 = s51 * s53; let s55 = s54 + s55; let s19 = s55 * s13;
let s55 = s0 * s9; let s50 = s50 * s10; let s55 = s50 - s55; let s50 = libm::sinh(s55); let s55 = libm::cosh(s55); let s56 = s1 * s50;
let s57 = s55 * s56; let s58 = s50 * s56; let s58 = s57 + s58; let s20 = s58 * s13; let s58 = s0 * s11; let s49 = s49 * s10;
let s58 = s49 - s58; let s49 = libm::sinh(s58); let s58 = libm::cosh(s58); let s59 = s2 * s49; let s60 = s58 * s59; let s61 = s49 * s59;
let s61 = s60 + s61; let s21 = s61 * s13; let s22 = s54 * s14; let s23 = s57 * s14; let s24 = s60 * s14; let s60 = s51 * s52;
let s57 = s51 * s51; let s57 = s60 + s57; let s57 = s57 * s13; let s25 = s12 + s57; let s57 = s43 * s43; let s57 = s44 * s57;
let s43 = s3 * s43; let s43 = s57 - s43; let s43 = s1 * s43; let s43 = s45 - s43; let s45 = s7 * s43; let s57 = s51 * s45;
let s45 = s52 * s45; let s44 = s0 * s45; let s57 = s53 * s57; let s54 = s52 * s44; let s54 = s57 + s54; let s45 = s53 * s45;
let s44 = s51 * s44; let s45 = s54 + s45; let s44 = s45 + s44; let s26 = s44 * s13; let s44 = s46 * s46; let s44 = s47 * s44;
let s46 = s5 * s46; let s46 = s44 - s46; let s46 = s2 * s46; let s46 = s48 - s46; let s48 = s8 * s46; let s44 = s51 * s48;
let s48 = s52 * s48; let s47 = s0 * s48; let s44 = s53 * s44; let s52 = s52 * s47; let s52 = s44 + s52; let s48 = s53 * s48;
let s47 = s51 * s47; let s48 = s52 + s48; let s47 = s48 + s47; let s47 = s47 * s13; let s27 = -s47; let s47 = s9 * s50;
let s48 = s9 * s55; let s51 = s1 * s48; let s47 = s56 * s47; let s53 = s55 * s51; let s53 = s47 + s53; let s48 = s56 * s48;
let s51 = s50 * s51; let s48 = s53 + s48; let s51 = s48 + s51; let s51 = s51 * s13; let s28 = -s51; let s51 = s50 * s55;
let s48 = s50 * s50; let s48 = s51 + s48; let s48 = s48 * s13; let s29 = s12 + s48; let s46 = s10 * s46; let s48 = s50 * s46;
let s46 = s55 * s46; let s47 = s1 * s46; let s48 = s56 * s48; let s55 = s55 * s47; let s55 = s48 + s55; let s46 = s56 * s46;
let s47 = s50 * s47; let s46 = s55 + s46; let s47 = s46 + s47; let s30 = s47 * s13; let s47 = s11 * s49; let s46 = s11 * s58;
let s50 = s2 * s46; let s47 = s59 * s47; let s56 = s58 * s50; let s56 = s47 + s56; let s46 = s59 * s46; let s50 = s49 * s50;
let s46 = s56 + s46; let s50 = s46 + s50; let s50 = s50 * s13; let s31 = -s50; let s43 = s10 * s43; let s50 = s49 * s43;
let s43 = s58 * s43; let s46 = s2 * s43; let s50 = s59 * s50; let s47 = s58 * s46; let s47 = s50 + s47; let s43 = s59 * s43;
let s46 = s49 * s46; let s43 = s47 + s43; let s46 = s43 + s46; let s32 = s46 * s13; let s58 = s49 * s58; let s49 = s49 * s49;
let s49 = s58 + s49; let s49 = s49 * s13; let s33 = s12 + s49; let s34 = s60 * s14; let s35 = s54 * s14; let s36 = s52 * s15;
let s37 = s53 * s15; let s38 = s51 * s14; let s39 = s55 * s14; let s40 = s56 * s15; let s41 = s47 * s14; let s42 = s58 * s14;
Full { residual: Residual { base: [s0, s1, s2], offset: [s19, s20, s21], increment: [s22, s23, s24], guard: [[0.0; 3]; 2] }, target: [[s25, s26, s27], [s28, s29, s30], [s31, s32, s33]], change: [[s34, s35, s36], [s37, s38, s39], [s40, s41, s42]] }
}
}
