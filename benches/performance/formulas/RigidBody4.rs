// Written by `cargo bench -p leafwise-benches --bench performance -- formulas`.
pub struct RigidBody4 { full: [f64; 11], residual: [f64; 8] }
impl RigidBody4 {
pub fn new(parameters: &[f64; 3], epsilon: f64, h: f64) -> Self {
let full = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = epsilon; let s4 = h; let s5 = 1.0_f64;
let s6 = 2.0_f64; let s7 = 0.08333333333333333_f64; let s8 = 3.141592653589793_f64; let s9 = 0.16666666666666666_f64; let s21 = s5 / s0; let s11 = s4 * s21;
let s22 = s5 / s1; let s12 = s4 * s22; let s23 = s5 / s2; let s13 = s4 * s23; let s24 = s3 * s4; let s24 = s24 * s24;
let s24 = s4 * s24; let s25 = s0 * s0; let s25 = s5 / s25; let s26 = s25 * s23; let s27 = s21 * s22; let s27 = s23 * s27;
let s28 = s1 * s1; let s28 = s5 / s28; let s23 = s23 * s28; let s29 = s27 * s6; let s23 = s26 + s23; let s29 = s23 - s29;
let s29 = s24 * s29; let s14 = s29 * s7; let s25 = s25 * s22; let s23 = s2 * s2; let s23 = s5 / s23; let s22 = s22 * s23;
let s26 = s27 * s6; let s25 = s26 - s25; let s22 = s25 - s22; let s22 = s24 * s22; let s15 = s22 * s7; let s28 = s21 * s28;
let s23 = s21 * s23; let s27 = s27 * s6; let s28 = s27 - s28; let s23 = s28 - s23; let s23 = s24 * s23; let s16 = s23 * s7;
let s18 = s22 * s9; let s19 = s29 * s9; let s20 = s23 * s9;
[
s3, s11, s12, s13, s14, s15, s16, s8, s18, s19, s20, ]
};
let residual = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = epsilon; let s4 = h; let s5 = 1.0_f64;
let s6 = 2.0_f64; let s7 = 0.08333333333333333_f64; let s8 = 3.141592653589793_f64; let s17 = s5 / s0; let s10 = s4 * s17; let s18 = s5 / s1;
let s11 = s4 * s18; let s19 = s5 / s2; let s12 = s4 * s19; let s20 = s3 * s4; let s20 = s20 * s20; let s20 = s4 * s20;
let s21 = s0 * s0; let s21 = s5 / s21; let s22 = s21 * s19; let s23 = s17 * s18; let s23 = s19 * s23; let s24 = s1 * s1;
let s24 = s5 / s24; let s19 = s19 * s24; let s25 = s23 * s6; let s19 = s22 + s19; let s25 = s19 - s25; let s25 = s20 * s25;
let s13 = s25 * s7; let s21 = s21 * s18; let s25 = s2 * s2; let s25 = s5 / s25; let s18 = s18 * s25; let s19 = s23 * s6;
let s21 = s19 - s21; let s18 = s21 - s18; let s18 = s20 * s18; let s14 = s18 * s7; let s24 = s17 * s24; let s25 = s17 * s25;
let s23 = s23 * s6; let s24 = s23 - s24; let s25 = s24 - s25; let s25 = s20 * s25; let s15 = s25 * s7;
[
s3, s10, s11, s12, s13, s14, s15, s8, ]
};
Self { full, residual }
}
}
impl Formulas<3> for RigidBody4 {
const MOST_CHORDS: u32 = 1;
#[inline(always)]
fn residual(&self, y: &[f64; 3]) -> Residual<3> {
let c = &self.residual;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = c[4]; let s8 = c[5]; let s9 = c[6]; let s10 = c[7]; let s11 = 0.5_f64;
let s12 = 1.998046875_f64; let s28 = s1 * s1; let s29 = s2 * s2; let s30 = s0 * s0; let s31 = s7 * s30; let s32 = s29 * s9;
let s31 = s5 + s31; let s32 = s31 - s32; let s32 = s1 * s32; let s30 = s8 * s30; let s31 = s28 * s9; let s30 = s6 - s30;
let s31 = s30 - s31; let s31 = s2 * s31; let s32 = s3 * s32; let s31 = s3 * s31; let s30 = s1 * s31; let s33 = s2 * s32;
let s33 = s30 - s33; let s30 = s33 * s11; let s28 = s28 * s7; let s29 = s29 * s8; let s28 = s4 + s28; let s29 = s28 - s29;
let s29 = s0 * s29; let s29 = s3 * s29; let s28 = s2 * s29; let s34 = s0 * s31; let s34 = s28 - s34; let s28 = s0 * s32;
let s35 = s1 * s29; let s35 = s28 - s35; let s28 = s29 * s29; let s36 = s32 * s32; let s37 = s31 * s31; let s36 = s28 + s36;
let s37 = s36 + s37; let s36 = COTANGENT.derivative(0, s37); let s28 = s31 * s34; let s38 = s32 * s35; let s38 = s28 - s38; let s38 = s36 * s38;
let s16 = s30 + s38; let s38 = s34 * s11; let s30 = s29 * s35; let s31 = s31 * s33; let s31 = s30 - s31; let s31 = s36 * s31;
let s17 = s38 + s31; let s31 = s35 * s11; let s32 = s32 * s33; let s29 = s29 * s34; let s29 = s32 - s29; let s29 = s36 * s29;
let s18 = s31 + s29; let s19 = -s33; let s20 = -s34; let s21 = -s35; let s22 = s10 * s12; let s25 = libm::sqrt(s37);
Residual { base: [s0, s1, s2], offset: [s16, s17, s18], increment: [s19, s20, s21], guard: [[s22, s22, s22], [s25, s25, s25]] }
}
#[inline(always)]
fn full(&self, y: &[f64; 3]) -> Full<3> {
let c = &self.full;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = c[4]; let s8 = c[5]; let s9 = c[6]; let s10 = c[7]; let s11 = c[8];
let s12 = c[9]; let s13 = c[10]; let s14 = 0.5_f64; let s15 = 1.0_f64; let s16 = 2.0_f64; let s17 = 1.998046875_f64;
let s51 = s1 * s1; let s52 = s2 * s2; let s53 = s0 * s0; let s54 = s7 * s53; let s55 = s52 * s9; let s54 = s5 + s54;
let s55 = s54 - s55; let s54 = s1 * s55; let s53 = s8 * s53; let s56 = s51 * s9; let s53 = s6 - s53; let s56 = s53 - s56;
let s53 = s2 * s56; let s54 = s3 * s54; let s53 = s3 * s53; let s57 = s1 * s53; let s58 = s2 * s54; let s58 = s57 - s58;
let s57 = s58 * s14; let s51 = s51 * s7; let s52 = s52 * s8; let s51 = s4 + s51; let s52 = s51 - s52; let s51 = s0 * s52;
let s51 = s3 * s51; let s59 = s2 * s51; let s60 = s0 * s53; let s60 = s59 - s60; let s59 = s0 * s54; let s61 = s1 * s51;
let s61 = s59 - s61; let s59 = s51 * s51; let s62 = s54 * s54; let s63 = s53 * s53; let s62 = s59 + s62; let s63 = s62 + s63;
let s62 = COTANGENT.derivative(0, s63); let s59 = s53 * s60; let s64 = s54 * s61; let s64 = s59 - s64; let s59 = s62 * s64; let s21 = s57 + s59;
let s59 = s60 * s14; let s57 = s51 * s61; let s65 = s53 * s58; let s65 = s57 - s65; let s57 = s62 * s65; let s22 = s59 + s57;
let s57 = s61 * s14; let s59 = s54 * s58; let s66 = s51 * s60; let s66 = s59 - s66; let s59 = s62 * s66; let s23 = s57 + s59;
let s24 = -s58; let s25 = -s60; let s26 = -s61; let s59 = s0 * s11; let s59 = s2 * s59; let s59 = s3 * s59;
let s57 = s1 * s59; let s67 = s0 * s12; let s67 = s1 * s67; let s67 = s3 * s67; let s68 = s2 * s67; let s36 = s57 + s68;
let s68 = s36 * s14; let s52 = s3 * s52; let s57 = s51 * s52; let s69 = s54 * s67; let s70 = s53 * s59; let s71 = COTANGENT.derivative(1, s63);
let s69 = s57 + s69; let s70 = s69 - s70; let s70 = s70 * s71; let s69 = s64 * s70; let s69 = s69 * s16; let s57 = s2 * s52;
let s72 = s0 * s59; let s57 = s57 - s53; let s72 = s57 + s72; let s57 = s60 * s59; let s73 = s53 * s72; let s74 = s0 * s67;
let s75 = s1 * s52; let s74 = s54 + s74; let s75 = s74 - s75; let s74 = s61 * s67; let s76 = s54 * s75; let s73 = s57 - s73;
let s74 = s73 + s74; let s76 = s74 + s76; let s76 = s62 * s76; let s68 = s15 - s68; let s69 = s68 + s69; let s27 = s69 - s76;
let s76 = s1 * s13; let s76 = s2 * s76; let s76 = s3 * s76; let s69 = s1 * s76; let s55 = s3 * s55; let s68 = s2 * s55;
let s69 = s53 - s69; let s68 = s69 - s68; let s69 = s68 * s14; let s74 = s1 * s12; let s74 = s0 * s74; let s74 = s3 * s74;
let s73 = s51 * s74; let s57 = s54 * s55; let s77 = s53 * s76; let s57 = s73 + s57; let s77 = s57 - s77; let s77 = s71 * s77;
let s57 = s64 * s77; let s57 = s57 * s16; let s73 = s2 * s74; let s78 = s0 * s76; let s78 = s73 + s78; let s73 = s60 * s76;
let s79 = s53 * s78; let s80 = s0 * s55; let s81 = s1 * s74; let s80 = s80 - s51; let s81 = s80 - s81; let s80 = s61 * s55;
let s82 = s54 * s81; let s79 = s73 - s79; let s80 = s79 + s80; let s82 = s80 + s82; let s82 = s62 * s82; let s57 = s69 + s57;
let s28 = s57 - s82; let s56 = s3 * s56; let s82 = s1 * s56; let s57 = s2 * s13; let s57 = s1 * s57; let s57 = s3 * s57;
let s69 = s2 * s57; let s82 = s82 - s54; let s69 = s82 + s69; let s82 = s69 * s14; let s80 = s2 * s11; let s80 = s0 * s80;
let s80 = s3 * s80; let s79 = s51 * s80; let s73 = s54 * s57; let s83 = s53 * s56; let s73 = s79 + s73; let s83 = s73 - s83;
let s83 = s71 * s83; let s64 = s64 * s83; let s64 = s64 * s16; let s71 = s2 * s80; let s73 = s0 * s56; let s71 = s51 - s71;
let s73 = s71 - s73; let s71 = s60 * s56; let s79 = s53 * s73; let s84 = s0 * s57; let s85 = s1 * s80; let s44 = s84 - s85;
let s85 = s61 * s57; let s84 = s54 * s44; let s79 = s71 + s79; let s85 = s79 + s85; let s84 = s85 + s84; let s84 = s62 * s84;
let s64 = s82 - s64; let s29 = s64 + s84; let s84 = s72 * s14; let s64 = s65 * s70; let s64 = s64 * s16; let s82 = s61 * s52;
let s85 = s51 * s75; let s59 = s58 * s59; let s79 = s53 * s36; let s85 = s82 + s85; let s59 = s85 + s59; let s79 = s59 + s79;
let s79 = s62 * s79; let s64 = s84 + s64; let s30 = s64 + s79; let s79 = s78 * s14; let s64 = s65 * s77; let s64 = s64 * s16;
let s84 = s61 * s74; let s59 = s51 * s81; let s76 = s58 * s76; let s85 = s53 * s68; let s59 = s84 + s59; let s76 = s59 + s76;
let s85 = s76 - s85; let s85 = s62 * s85; let s79 = s15 + s79; let s64 = s79 + s64; let s31 = s64 + s85; let s85 = s73 * s14;
let s65 = s65 * s83; let s65 = s65 * s16; let s61 = s61 * s80; let s64 = s51 * s44; let s56 = s58 * s56; let s53 = s53 * s69;
let s64 = s61 + s64; let s56 = s64 + s56; let s53 = s56 + s53; let s53 = s62 * s53; let s65 = s85 - s65; let s32 = s65 - s53;
let s53 = s75 * s14; let s70 = s66 * s70; let s70 = s70 * s16; let s67 = s58 * s67; let s65 = s54 * s36; let s52 = s60 * s52;
let s85 = s51 * s72; let s65 = s67 - s65; let s52 = s65 - s52; let s85 = s52 - s85; let s85 = s62 * s85; let s70 = s53 + s70;
let s33 = s70 + s85; let s85 = s81 * s14; let s77 = s66 * s77; let s77 = s77 * s16; let s55 = s58 * s55; let s70 = s54 * s68;
let s74 = s60 * s74; let s53 = s51 * s78; let s70 = s55 + s70; let s74 = s70 - s74; let s53 = s74 - s53; let s53 = s62 * s53;
let s77 = s85 + s77; let s34 = s77 + s53; let s53 = s44 * s14; let s83 = s66 * s83; let s83 = s83 * s16; let s57 = s58 * s57;
let s54 = s54 * s69; let s80 = s60 * s80; let s51 = s51 * s73; let s54 = s57 - s54; let s80 = s54 - s80; let s51 = s80 + s51;
let s51 = s62 * s51; let s53 = s15 - s53; let s83 = s53 - s83; let s35 = s83 - s51; let s37 = -s68; let s38 = -s69;
let s39 = -s72; let s40 = -s78; let s41 = -s73; let s42 = -s75; let s43 = -s81; let s45 = s10 * s17;
let s48 = libm::sqrt(s63);
Full { residual: Residual { base: [s0, s1, s2], offset: [s21, s22, s23], increment: [s24, s25, s26], guard: [[s45, s45, s45], [s48, s48, s48]] }, target: [[s27, s28, s29], [s30, s31, s32], [s33, s34, s35]], change: [[s36, s37, s38], [s39, s40, s41], [s42, s43, s44]] }
}
}
