//! γ_1, …, γ_{(s+1)/2} of the schemes: outermost first, the centre last; γ_{s+1−i} = γ_i. Of Blanes and Moan's
//! α_1, …, α_s; α_{2s+1−i} = α_i.

/// γ_1 = 1/(2 − 2^{1/3}): H. Yoshida, Physics Letters A 150, 262–268 (1990); E. Forest, R. Ruth,
/// Physica D 43, 105–117 (1990); M. Creutz, A. Gocksch, Physical Review Letters 63, 9–12 (1989).
pub const TRIPLE_JUMP: [f64; 2] = [1.351_207_191_959_657_5, -1.702_414_383_919_315_3];

/// γ_1 = γ_2 = 1/(4 − 4^{1/3}): M. Suzuki, Physics Letters A 146, 319–323 (1990).
pub const SUZUKI_4: [f64; 3] = [
    0.414_490_771_794_375_7,
    0.414_490_771_794_375_7,
    -0.657_963_087_177_503,
];

/// Solution A: H. Yoshida, Physics Letters A 150, 262–268 (1990), table 1; to more digits in
/// Hairer, Lubich, Wanner, *Geometric Numerical Integration*, (V.3.11).
pub const YOSHIDA_6: [f64; 4] = [
    0.784_513_610_477_557_3,
    0.235_573_213_359_358_13,
    -1.177_679_984_178_871,
    1.315_186_320_683_911_2,
];

/// W. Kahan, R.-C. Li, Mathematics of Computation 66, 1089–1099 (1997), s9odr6a; Hairer, Lubich,
/// Wanner, (V.3.12).
pub const KAHAN_LI_6: [f64; 5] = [
    0.392_161_444_007_314_1,
    0.332_599_136_789_359_43,
    -0.706_246_172_557_639_3,
    0.082_213_596_293_550_8,
    0.798_543_990_934_83,
];

/// M. Suzuki, K. Umeno, Springer Proceedings in Physics 76, 74–86 (1993); R. I. McLachlan, SIAM
/// Journal on Scientific Computing 16, 151–168 (1995); Hairer, Lubich, Wanner, (V.3.13).
pub const SUZUKI_UMENO_8: [f64; 8] = [
    0.741_670_364_350_613,
    -0.409_100_825_800_031_6,
    0.190_754_710_296_238_4,
    -0.573_862_471_116_082_2,
    0.299_064_181_303_655_9,
    0.334_624_918_245_298_16,
    0.315_293_092_396_766_6,
    -0.796_887_939_352_916_4,
];

/// W. Kahan, R.-C. Li (1997), s17odr8a; Hairer, Lubich, Wanner, (V.3.14).
pub const KAHAN_LI_8: [f64; 9] = [
    0.130_202_483_088_890_07,
    0.561_162_981_775_108_4,
    -0.389_474_962_644_847_27,
    0.158_841_906_555_155_6,
    -0.395_903_894_133_237_57,
    0.184_539_640_978_315_7,
    0.258_374_387_686_322_04,
    0.295_011_723_609_310_3,
    -0.605_508_533_830_034_6,
];

/// W. Kahan, R.-C. Li (1997), s31odr10a, the one of their 31-stage methods of order 10 with the
/// smaller error terms of grade 11.
pub const KAHAN_LI_10: [f64; 16] = [
    -0.481_598_956_002_530_05,
    0.003_630_393_154_459_592_7,
    0.501_803_175_587_231_4,
    0.282_984_026_245_062_5,
    0.807_029_678_953_722_2,
    -0.026_090_580_538_592_204,
    -0.872_865_901_463_180_7,
    -0.523_735_680_625_105_8,
    0.445_218_442_999_527_9,
    0.186_122_895_470_979_07,
    0.231_373_278_664_383_62,
    -0.521_910_365_904_186_3,
    0.748_661_137_144_992_9,
    0.066_736_511_890_604_06,
    -0.803_603_243_756_708_3,
    0.912_490_376_358_679_9,
];

/// M. Sofroniou, G. Spaletta, Optimization Methods and Software 20, 597–613 (2005); Hairer, Lubich,
/// Wanner, second edition, (V.3.15).
pub const SOFRONIOU_SPALETTA_10: [f64; 18] = [
    0.078_795_722_521_686_41,
    0.313_096_103_415_108_5,
    0.027_918_383_235_078_066,
    -0.229_592_841_593_907_08,
    0.130_962_061_077_164_88,
    -0.269_733_405_654_510_7,
    0.074_973_343_155_891_44,
    0.111_993_423_999_810_2,
    0.366_133_449_546_226_73,
    -0.399_105_630_136_035_9,
    0.103_087_398_527_471_08,
    0.411_430_873_955_890_23,
    -0.004_866_360_583_135_261_6,
    -0.392_033_353_708_639_9,
    0.051_942_502_962_449_65,
    0.050_665_090_759_924_494,
    0.049_674_370_639_729_876,
    0.049_317_735_759_594_535,
];

/// Compositions from the splittings S₆ in two pieces over a_i and b_i: S. Blanes, P. C. Moan, Journal of Computational
/// and Applied Mathematics 142, 313–330 (2002), table 2. With α_1 = a_1, α_2 = b_1 − α_1, α_3 = a_2 − α_2, … they have
/// the same order over any number of pieces. The source of this is R. I. McLachlan, SIAM Journal on Scientific
/// Computing 16, 151–168 (1995). The printed 15 digits were continued by Newton's method on the order conditions to
/// the nearest solution, 8e-17 away.
pub const BLANES_MOAN_4: [f64; 6] = [
    0.079_203_696_431_195_67,
    0.130_311_410_182_166_38,
    0.222_861_495_867_607_67,
    -0.366_713_269_047_425_74,
    0.324_648_188_689_706_2,
    0.109_688_477_876_749_82,
];

/// S. Blanes, P. C. Moan (2002), S₁₀, continued likewise, 1.4e-15 away.
pub const BLANES_MOAN_6: [f64; 10] = [
    0.050_262_764_400_392_59,
    0.098_553_683_500_650_51,
    0.314_960_616_927_694_17,
    -0.447_346_482_695_477_55,
    0.492_426_372_489_875_5,
    -0.425_118_767_797_690_87,
    0.237_063_913_978_121_18,
    0.195_602_488_600_052_1,
    0.346_358_189_850_728_36,
    -0.362_762_779_254_345_97,
];

/// Compositions from the splitting SRKN₆ᵇ, over the flows of V and T in turn, V first: S. Blanes, P. C. Moan (2002),
/// table 3. The coefficients are α_1 = b_1, α_2 = a_1 − α_1, …; the order is 4 where {V, {V, {V, T}}} = 0. The printed
/// 15 digits were continued by Newton's method on the order conditions in words over V and T modulo that bracket. The
/// nearest solution is 3e-16 away.
pub const NYSTROM_4: [f64; 6] = [
    0.082_984_406_417_405_16,
    0.162_314_550_766_866_16,
    0.233_995_250_731_502,
    0.370_877_414_979_577_77,
    -0.409_933_719_901_926_3,
    0.059_762_097_006_575_17,
];

/// S. Blanes, P. C. Moan (2002), table 3, SRKN₁₁ᵇ, V first, continued likewise, 7e-16 away.
pub const NYSTROM_6: [f64; 11] = [
    0.041_464_998_518_262_845,
    0.081_764_777_428_008_29,
    0.116_363_894_490_058_16,
    0.174_189_903_309_500_15,
    -0.214_196_095_413_652_86,
    0.087_146_882_788_235_65,
    -0.011_892_898_486_655_41,
    -0.234_438_862_575_419_93,
    0.222_927_475_154_732_2,
    0.134_281_397_641_195_73,
    0.102_388_527_145_735_15,
];

/// S. Blanes, P. C. Moan (2002), table 3, SRKN₁₄ᵃ, T first, continued likewise, 3e-15 away.
pub const NYSTROM_6_LONG: [f64; 14] = [
    0.037_859_319_840_611_25,
    0.053_859_832_783_850_856,
    0.048_775_800_318_585_18,
    0.135_207_369_686_420_83,
    -0.161_075_257_952_979,
    0.104_540_892_120_089_21,
    0.209_700_510_951_355_36,
    -0.204_785_822_176_643_3,
    0.074_641_362_659_230_92,
    0.069_119_764_509_131_35,
    0.037_297_935_860_410_567,
    0.291_269_757_886_391_4,
    -0.300_064_001_014_901_66,
    0.103_652_534_528_446_97,
];

/// α_1 = c_1, α_2 = d_1 − c_1, α_3 = c_2 − α_2, α_4 = d_2 − α_3 from Gauss's quadrature on [0, 1]. Its nodes are c_1,
/// c_1 + c_2, … and its weights d_1, d_2, …. Sources are R. I. McLachlan, BIT 35, 258–268 (1995); J. Laskar, P.
/// Robutel, Celestial Mechanics and Dynamical Astronomy 80, 39–62 (2001), SABA₄.
pub const PERTURBED_8_2: [f64; 4] = [
    0.069_431_844_202_973_71,
    0.104_495_578_365_753_21,
    0.156_082_055_638_844_95,
    0.169_990_521_792_428_13,
];

/// S. Blanes, F. Casas, A. Farrés, J. Laskar, J. Makazaga, A. Murua, Applied Numerical Mathematics 68, 58–72 (2013),
/// ABA(10,4) with the flow of A first, as α_1 = a_1, α_2 = b_1 − α_1, …. The printed digits were continued by Newton's
/// method on the order conditions in words over A and B. These take one B up to grade 10 and two or more up to grade
/// 4; the solution is 4e-17 away.
pub const PERTURBED_10_4: [f64; 7] = [
    0.047_067_100_645_972_505,
    0.071_814_816_722_224_52,
    0.112_942_118_694_863_59,
    0.128_108_341_856_637_97,
    0.154_597_663_823_198_23,
    -0.427_884_330_528_522_04,
    0.413_354_288_785_625_25,
];

/// The same authors, ABA(8,6,4): one B up to grade 8, two up to 6, three or more up to 4; continued likewise, 7e-17 away.
pub const PERTURBED_8_6_4: [f64; 7] = [
    0.071_133_426_498_223_12,
    0.111_950_260_973_974_1,
    0.129_203_166_982_665_98,
    0.181_579_692_915_908_86,
    0.339_832_068_856_905_9,
    -0.366_396_687_368_864_7,
    0.032_698_071_141_186_71,
];

/// The same authors, ABA(10,6,4): one B up to grade 10, two up to 6, three or more up to 4; continued likewise, 6e-17
/// away.
pub const PERTURBED_10_6_4: [f64; 8] = [
    0.038_094_497_422_412_193,
    0.057_764_383_414_663_015,
    0.087_534_332_702_250_74,
    0.116_911_820_440_748_05,
    0.090_715_875_284_793_2,
    0.126_354_472_694_197_9,
    0.309_555_230_957_328_3,
    -0.326_930_612_916_393_36,
];
