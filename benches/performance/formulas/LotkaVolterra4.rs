// Written by `cargo bench -p leafwise-benches --bench performance -- formulas`.
pub struct LotkaVolterra4 { full: [f64; 24], residual: [f64; 24] }
impl LotkaVolterra4 {
pub fn new(parameters: &[f64; 5], epsilon: f64, h: f64) -> Self {
let full = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = parameters[3]; let s4 = parameters[4]; let s5 = epsilon;
let s6 = h; let s7 = 0.08333333333333333_f64; let s8 = 0.041666666666666664_f64; let s9 = 2.0_f64; let s10 = 0.25_f64; let s11 = s6 * s3;
let s12 = s6 * s4; let s35 = s5 * s6; let s35 = s35 * s35; let s35 = s6 * s35; let s36 = s2 * s2; let s37 = s1 * s1;
let s38 = s36 * s37; let s39 = s0 * s0; let s40 = s38 * s39; let s41 = s35 * s40; let s13 = s41 * s7; let s42 = s1 * s2;
let s43 = s39 * s42; let s44 = s2 * s37; let s44 = s39 * s44; let s43 = s40 + s43; let s43 = s43 - s44; let s43 = s35 * s43;
let s14 = s43 * s7; let s43 = s1 * s36; let s43 = s0 * s43; let s45 = s35 * s43; let s15 = s45 * s8; let s38 = s0 * s38;
let s46 = s0 * s42; let s46 = s4 * s46; let s47 = s43 * s3; let s48 = s38 * s4; let s47 = s46 - s47; let s48 = s47 + s48;
let s48 = s35 * s48; let s16 = s48 * s7; let s48 = s37 * s37; let s48 = s36 * s48; let s47 = s0 * s39; let s48 = s48 * s47;
let s48 = s35 * s48; let s17 = s48 * s7; let s37 = s1 * s37; let s37 = s36 * s37; let s47 = s37 * s47; let s47 = s35 * s47;
let s18 = s47 * s8; let s44 = s3 * s44; let s40 = s3 * s40; let s36 = s37 * s39; let s36 = s4 * s36; let s40 = s44 - s40;
let s36 = s40 + s36; let s36 = s35 * s36; let s19 = s36 * s7; let s36 = s1 * s0; let s36 = s6 * s36; let s40 = s3 * s3;
let s43 = s43 * s40; let s38 = s3 * s38; let s38 = s38 * s4; let s37 = s0 * s37; let s44 = s4 * s4; let s37 = s37 * s44;
let s38 = s38 * s9; let s37 = s43 + s37; let s38 = s37 - s38; let s38 = s35 * s38; let s38 = s38 * s8; let s20 = s36 + s38;
let s21 = s45 * s7; let s22 = s41 * s8; let s41 = s35 * s0; let s23 = s41 * s7; let s39 = s35 * s39; let s24 = s39 * s8;
let s45 = s0 * s3; let s38 = s0 * s4; let s38 = s45 - s38; let s38 = s35 * s38; let s25 = s38 * s7; let s44 = s35 * s44;
let s44 = s44 * s8; let s26 = s6 + s44; let s27 = s47 * s7; let s28 = s48 * s8; let s29 = s39 * s7; let s30 = s41 * s8;
let s41 = s6 * s0; let s40 = s0 * s40; let s40 = s35 * s40; let s40 = s40 * s8; let s31 = s41 + s40; let s40 = s5 * s2;
let s32 = s40 * s10; let s42 = s5 * s42; let s33 = s42 * s10; let s34 = s5 * s10;
[
s11, s12, s13, s14, s15, s16, s17, s18, s19, s20, s21, s22, s23, s24, s25, s26, s27, s28, s29, s30, s31, s32, s33, s34, ]
};
let residual = {
let s0 = parameters[0]; let s1 = parameters[1]; let s2 = parameters[2]; let s3 = parameters[3]; let s4 = parameters[4]; let s5 = epsilon;
let s6 = h; let s7 = 0.08333333333333333_f64; let s8 = 0.041666666666666664_f64; let s9 = 2.0_f64; let s10 = 0.25_f64; let s11 = s6 * s3;
let s12 = s6 * s4; let s35 = s5 * s6; let s35 = s35 * s35; let s35 = s6 * s35; let s36 = s2 * s2; let s37 = s1 * s1;
let s38 = s36 * s37; let s39 = s0 * s0; let s40 = s38 * s39; let s41 = s35 * s40; let s13 = s41 * s7; let s42 = s1 * s2;
let s43 = s39 * s42; let s44 = s2 * s37; let s44 = s39 * s44; let s43 = s40 + s43; let s43 = s43 - s44; let s43 = s35 * s43;
let s14 = s43 * s7; let s43 = s1 * s36; let s43 = s0 * s43; let s45 = s35 * s43; let s15 = s45 * s8; let s38 = s0 * s38;
let s46 = s0 * s42; let s46 = s4 * s46; let s47 = s43 * s3; let s48 = s38 * s4; let s47 = s46 - s47; let s48 = s47 + s48;
let s48 = s35 * s48; let s16 = s48 * s7; let s48 = s37 * s37; let s48 = s36 * s48; let s47 = s0 * s39; let s48 = s48 * s47;
let s48 = s35 * s48; let s17 = s48 * s7; let s37 = s1 * s37; let s37 = s36 * s37; let s47 = s37 * s47; let s47 = s35 * s47;
let s18 = s47 * s8; let s44 = s3 * s44; let s40 = s3 * s40; let s36 = s37 * s39; let s36 = s4 * s36; let s40 = s44 - s40;
let s36 = s40 + s36; let s36 = s35 * s36; let s19 = s36 * s7; let s36 = s1 * s0; let s36 = s6 * s36; let s40 = s3 * s3;
let s43 = s43 * s40; let s38 = s3 * s38; let s38 = s38 * s4; let s37 = s0 * s37; let s44 = s4 * s4; let s37 = s37 * s44;
let s38 = s38 * s9; let s37 = s43 + s37; let s38 = s37 - s38; let s38 = s35 * s38; let s38 = s38 * s8; let s20 = s36 + s38;
let s21 = s45 * s7; let s22 = s41 * s8; let s41 = s35 * s0; let s23 = s41 * s7; let s39 = s35 * s39; let s24 = s39 * s8;
let s45 = s0 * s3; let s38 = s0 * s4; let s38 = s45 - s38; let s38 = s35 * s38; let s25 = s38 * s7; let s44 = s35 * s44;
let s44 = s44 * s8; let s26 = s6 + s44; let s27 = s47 * s7; let s28 = s48 * s8; let s29 = s39 * s7; let s30 = s41 * s8;
let s41 = s6 * s0; let s40 = s0 * s40; let s40 = s35 * s40; let s40 = s40 * s8; let s31 = s41 + s40; let s40 = s5 * s2;
let s32 = s40 * s10; let s42 = s5 * s42; let s33 = s42 * s10; let s34 = s5 * s10;
[
s11, s12, s13, s14, s15, s16, s17, s18, s19, s20, s21, s22, s23, s24, s25, s26, s27, s28, s29, s30, s31, s32, s33, s34, ]
};
Self { full, residual }
}
}
impl Formulas<3> for LotkaVolterra4 {
const MOST_CHORDS: u32 = 1;
#[inline(always)]
fn residual(&self, y: &[f64; 3]) -> Residual<3> {
let c = &self.residual;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = c[4]; let s8 = c[5]; let s9 = c[6]; let s10 = c[7]; let s11 = c[8];
let s12 = c[9]; let s13 = c[10]; let s14 = c[11]; let s15 = c[12]; let s16 = c[13]; let s17 = c[14];
let s18 = c[15]; let s19 = c[16]; let s20 = c[17]; let s21 = c[18]; let s22 = c[19]; let s23 = c[20];
let s24 = c[21]; let s25 = c[22]; let s26 = c[23]; let s27 = 1.0_f64; let s28 = 2.0_f64; let s29 = -4.0_f64;
let s39 = s2 * s6; let s40 = s27 / s1; let s41 = s1 * s13; let s42 = s0 * s14; let s43 = s39 + s8; let s41 = s43 - s41;
let s42 = s41 - s42; let s42 = s0 * s42; let s41 = s1 * s15; let s43 = s2 * s16; let s43 = s41 - s43; let s43 = s43 + s17;
let s43 = s2 * s43; let s43 = s42 + s43; let s43 = s43 - s18; let s43 = s1 * s43; let s43 = s3 - s43; let s43 = s40 * s43;
let s40 = s27 / s2; let s42 = s1 * s6; let s41 = s2 * s19; let s44 = s0 * s20; let s42 = s11 - s42; let s41 = s42 + s41;
let s44 = s41 - s44; let s44 = s0 * s44; let s41 = s2 * s21; let s42 = s1 * s22; let s41 = s17 - s41; let s42 = s41 + s42;
let s42 = s1 * s42; let s42 = s44 - s42; let s42 = s42 - s23; let s42 = s2 * s42; let s42 = s4 - s42; let s42 = s40 * s42;
let s43 = s1 * s43; let s42 = s2 * s42; let s40 = s43 * s24; let s44 = s42 * s25; let s44 = s40 - s44; let s40 = libm::sinh(s44);
let s44 = libm::cosh(s44); let s41 = s0 * s40; let s44 = s44 * s41; let s41 = s40 * s41; let s41 = s44 + s41; let s33 = s41 * s28;
let s41 = s0 * s5; let s40 = s1 * s7; let s39 = s41 - s39; let s40 = s39 + s40; let s40 = s40 - s8; let s40 = s1 * s40;
let s39 = s0 * s9; let s41 = s2 * s10; let s41 = s39 - s41; let s41 = s41 - s11; let s41 = s2 * s41; let s41 = s40 - s41;
let s41 = s41 + s12; let s41 = s0 * s41; let s40 = s41 * s24; let s42 = s42 * s26; let s40 = s42 - s40; let s42 = libm::sinh(s40);
let s40 = libm::cosh(s40); let s39 = s1 * s42; let s40 = s40 * s39; let s39 = s42 * s39; let s39 = s40 + s39; let s34 = s39 * s28;
let s41 = s41 * s25; let s43 = s43 * s26; let s41 = s43 - s41; let s43 = libm::sinh(s41); let s41 = libm::cosh(s41); let s39 = s2 * s43;
let s41 = s41 * s39; let s39 = s43 * s39; let s39 = s41 + s39; let s35 = s39 * s28; let s36 = s44 * s29; let s37 = s40 * s29;
let s38 = s41 * s29;
Residual { base: [s0, s1, s2], offset: [s33, s34, s35], increment: [s36, s37, s38], guard: [[0.0; 3]; 2] }
}
#[inline(always)]
fn full(&self, y: &[f64; 3]) -> Full<3> {
let c = &self.full;
let s0 = y[0]; let s1 = y[1]; let s2 = y[2]; let s3 = c[0]; let s4 = c[1]; let s5 = c[2];
let s6 = c[3]; let s7 = c[4]; let s8 = c[5]; let s9 = c[6]; let s10 = c[7]; let s11 = c[8];
let s12 = c[9]; let s13 = c[10]; let s14 = c[11]; let s15 = c[12]; let s16 = c[13]; let s17 = c[14];
let s18 = c[15]; let s19 = c[16]; let s20 = c[17]; let s21 = c[18]; let s22 = c[19]; let s23 = c[20];
let s24 = c[21]; let s25 = c[22]; let s26 = c[23]; let s27 = 1.0_f64; let s28 = 2.0_f64; let s29 = -4.0_f64;
let s30 = 4.0_f64; let s58 = s2 * s6; let s59 = s27 / s1; let s60 = s1 * s13; let s61 = s0 * s14; let s62 = s58 + s8;
let s60 = s62 - s60; let s60 = s60 - s61; let s62 = s0 * s60; let s63 = s1 * s15; let s64 = s2 * s16; let s63 = s63 - s64;
let s63 = s63 + s17; let s65 = s2 * s63; let s65 = s62 + s65; let s65 = s65 - s18; let s62 = s1 * s65; let s62 = s3 - s62;
let s66 = s59 * s62; let s67 = s27 / s2; let s68 = s1 * s6; let s69 = s2 * s19; let s70 = s0 * s20; let s71 = s11 - s68;
let s69 = s71 + s69; let s69 = s69 - s70; let s71 = s0 * s69; let s72 = s2 * s21; let s73 = s1 * s22; let s72 = s17 - s72;
let s72 = s72 + s73; let s74 = s1 * s72; let s74 = s71 - s74; let s74 = s74 - s23; let s71 = s2 * s74; let s71 = s4 - s71;
let s75 = s67 * s71; let s76 = s1 * s66; let s77 = s2 * s75; let s78 = s76 * s24; let s79 = s77 * s25; let s79 = s78 - s79;
let s78 = libm::sinh(s79); let s79 = libm::cosh(s79); let s80 = s0 * s78; let s81 = s79 * s80; let s82 = s78 * s80; let s82 = s81 + s82;
let s34 = s82 * s28; let s82 = s0 * s5; let s83 = s1 * s7; let s58 = s82 - s58; let s58 = s58 + s83; let s58 = s58 - s8;
let s82 = s1 * s58; let s84 = s0 * s9; let s85 = s2 * s10; let s84 = s84 - s85; let s84 = s84 - s11; let s86 = s2 * s84;
let s86 = s82 - s86; let s86 = s86 + s12; let s82 = s0 * s86; let s87 = s82 * s24; let s77 = s77 * s26; let s87 = s77 - s87;
let s77 = libm::sinh(s87); let s87 = libm::cosh(s87); let s88 = s1 * s77; let s89 = s87 * s88; let s90 = s77 * s88; let s90 = s89 + s90;
let s35 = s90 * s28; let s82 = s82 * s25; let s76 = s76 * s26; let s82 = s76 - s82; let s76 = libm::sinh(s82); let s82 = libm::cosh(s82);
let s90 = s2 * s76; let s91 = s82 * s90; let s92 = s76 * s90; let s92 = s91 + s92; let s36 = s92 * s28; let s37 = s81 * s29;
let s38 = s89 * s29; let s39 = s91 * s29; let s60 = s61 - s60; let s60 = s1 * s60; let s60 = s59 * s60; let s60 = s1 * s60;
let s61 = s24 * s60; let s69 = s70 - s69; let s69 = s2 * s69; let s69 = s67 * s69; let s69 = s2 * s69; let s70 = s25 * s69;
let s70 = s61 - s70; let s61 = s78 * s70; let s70 = s79 * s70; let s91 = s0 * s70; let s91 = s78 + s91; let s61 = s80 * s61;
let s89 = s79 * s91; let s89 = s61 + s89; let s70 = s80 * s70; let s91 = s78 * s91; let s70 = s89 + s70; let s91 = s70 + s91;
let s91 = s91 * s28; let s40 = s27 + s91; let s91 = s59 * s59; let s70 = s0 * s13; let s61 = s2 * s15; let s61 = s70 - s61;
let s61 = s1 * s61; let s91 = s62 * s91; let s61 = s65 - s61; let s61 = s59 * s61; let s61 = s91 + s61; let s61 = s1 * s61;
let s61 = s66 - s61; let s66 = s24 * s61; let s91 = s0 * s6; let s73 = s91 + s73; let s72 = s73 + s72; let s72 = s2 * s72;
let s72 = s67 * s72; let s72 = s2 * s72; let s73 = s25 * s72; let s73 = s66 - s73; let s66 = s78 * s73; let s73 = s79 * s73;
let s65 = s0 * s73; let s66 = s80 * s66; let s62 = s79 * s65; let s62 = s66 + s62; let s73 = s80 * s73; let s65 = s78 * s65;
let s73 = s62 + s73; let s65 = s73 + s65; let s41 = s65 * s28; let s64 = s91 - s64; let s63 = s64 + s63; let s63 = s1 * s63;
let s63 = s59 * s63; let s63 = s1 * s63; let s59 = s24 * s63; let s64 = s67 * s67; let s91 = s0 * s19; let s65 = s1 * s21;
let s65 = s91 + s65; let s65 = s2 * s65; let s64 = s71 * s64; let s65 = s74 + s65; let s65 = s67 * s65; let s65 = s64 + s65;
let s65 = s2 * s65; let s65 = s75 - s65; let s75 = s25 * s65; let s75 = s59 + s75; let s59 = s78 * s75; let s75 = s79 * s75;
let s64 = s0 * s75; let s59 = s80 * s59; let s79 = s79 * s64; let s79 = s59 + s79; let s75 = s80 * s75; let s64 = s78 * s64;
let s75 = s79 + s75; let s64 = s75 + s64; let s64 = s64 * s28; let s42 = -s64; let s64 = s1 * s5; let s75 = s2 * s9;
let s75 = s64 - s75; let s75 = s0 * s75; let s75 = s86 + s75; let s86 = s24 * s75; let s69 = s26 * s69; let s69 = s86 - s69;
let s86 = s77 * s69; let s69 = s87 * s69; let s64 = s1 * s69; let s86 = s88 * s86; let s78 = s87 * s64; let s78 = s86 + s78;
let s69 = s88 * s69; let s64 = s77 * s64; let s69 = s78 + s69; let s64 = s69 + s64; let s64 = s64 * s28; let s43 = -s64;
let s58 = s83 + s58; let s58 = s0 * s58; let s83 = s24 * s58; let s72 = s26 * s72; let s72 = s83 - s72; let s83 = s77 * s72;
let s72 = s87 * s72; let s64 = s1 * s72; let s64 = s77 - s64; let s83 = s88 * s83; let s69 = s87 * s64; let s69 = s83 - s69;
let s72 = s88 * s72; let s64 = s77 * s64; let s64 = s64 - s69; let s72 = s64 - s72; let s72 = s72 * s28; let s44 = s27 + s72;
let s85 = s68 - s85; let s84 = s85 + s84; let s84 = s0 * s84; let s85 = s24 * s84; let s65 = s26 * s65; let s65 = s85 + s65;
let s85 = s77 * s65; let s65 = s87 * s65; let s68 = s1 * s65; let s85 = s88 * s85; let s87 = s87 * s68; let s87 = s85 + s87;
let s65 = s88 * s65; let s68 = s77 * s68; let s65 = s87 + s65; let s68 = s65 + s68; let s45 = s68 * s28; let s75 = s25 * s75;
let s60 = s26 * s60; let s60 = s75 - s60; let s75 = s76 * s60; let s60 = s82 * s60; let s68 = s2 * s60; let s75 = s90 * s75;
let s65 = s82 * s68; let s65 = s75 + s65; let s60 = s90 * s60; let s68 = s76 * s68; let s60 = s65 + s60; let s68 = s60 + s68;
let s68 = s68 * s28; let s46 = -s68; let s58 = s25 * s58; let s61 = s26 * s61; let s61 = s58 - s61; let s58 = s76 * s61;
let s61 = s82 * s61; let s68 = s2 * s61; let s58 = s90 * s58; let s60 = s82 * s68; let s60 = s58 + s60; let s61 = s90 * s61;
let s68 = s76 * s68; let s61 = s60 + s61; let s68 = s61 + s68; let s68 = s68 * s28; let s47 = -s68; let s84 = s25 * s84;
let s63 = s26 * s63; let s63 = s84 - s63; let s84 = s76 * s63; let s63 = s82 * s63; let s68 = s2 * s63; let s68 = s76 + s68;
let s84 = s90 * s84; let s82 = s82 * s68; let s82 = s84 + s82; let s63 = s90 * s63; let s68 = s76 * s68; let s63 = s82 + s63;
let s68 = s63 + s68; let s68 = s68 * s28; let s48 = s27 + s68; let s49 = s89 * s29; let s50 = s62 * s29; let s51 = s79 * s30;
let s52 = s78 * s30; let s53 = s69 * s30; let s54 = s87 * s29; let s55 = s65 * s30; let s56 = s60 * s30; let s57 = s82 * s29;
Full { residual: Residual { base: [s0, s1, s2], offset: [s34, s35, s36], increment: [s37, s38, s39], guard: [[0.0; 3]; 2] }, target: [[s40, s41, s42], [s43, s44, s45], [s46, s47, s48]], change: [[s49, s50, s51], [s52, s53, s54], [s55, s56, s57]] }
}
}
