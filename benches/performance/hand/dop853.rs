//! DOP853: the pair of order 8(5,3) of Dormand and Prince, without dense output.
//!
//! Coefficients and control of the step: Hairer, Nørsett, Wanner, *Solving Ordinary Differential Equations I*, section
//! II.5, and `dop853.f` (Hairer, Wanner 1994). Only products with coefficients that are not 0.

/// The state after `time`, and the evaluations of the field; `tolerance` absolute and relative. `None` where the
/// steps end at round-off.
#[expect(
    clippy::disallowed_methods,
    reason = "a baseline takes the functions of the platform"
)]
#[inline(always)]
pub fn integrate<const D: usize>(
    field: impl Fn(&[f64; D]) -> [f64; D],
    mut x: [f64; D],
    time: f64,
    tolerance: f64,
) -> Option<([f64; D], u64)> {
    let mut evaluations = 2;
    let mut k1 = field(&x);
    let mut h = first(&field, &x, &k1, time, tolerance);
    let (mut done, mut rejected) = (0.0, false);
    while done < time {
        let last = done + 1.01 * h >= time;
        if last {
            h = time - done;
        }
        if h <= 4.0 * f64::EPSILON * time {
            return None;
        }
        let k2 = field(&std::array::from_fn(|c| {
            x[c] + h * (0.05260015195876773 * k1[c])
        }));
        let k3 = field(&std::array::from_fn(|c| {
            x[c] + h * (0.0197250569845379 * k1[c] + 0.0591751709536137 * k2[c])
        }));
        let k4 = field(&std::array::from_fn(|c| {
            x[c] + h * (0.02958758547680685 * k1[c] + 0.08876275643042054 * k3[c])
        }));
        let k5 = field(&std::array::from_fn(|c| {
            x[c] + h
                * (0.2413651341592667 * k1[c] - 0.8845494793282861 * k3[c]
                    + 0.924834003261792 * k4[c])
        }));
        let k6 = field(&std::array::from_fn(|c| {
            x[c] + h
                * (0.037037037037037035 * k1[c]
                    + 0.17082860872947386 * k4[c]
                    + 0.12546768756682242 * k5[c])
        }));
        let k7 = field(&std::array::from_fn(|c| {
            x[c] + h
                * (0.037109375 * k1[c] + 0.17025221101954405 * k4[c] + 0.06021653898045596 * k5[c]
                    - 0.017578125 * k6[c])
        }));
        let k8 = field(&std::array::from_fn(|c| {
            x[c] + h
                * (0.03709200011850479 * k1[c]
                    + 0.17038392571223998 * k4[c]
                    + 0.10726203044637328 * k5[c]
                    - 0.015319437748624402 * k6[c]
                    + 0.008273789163814023 * k7[c])
        }));
        let k9 = field(&std::array::from_fn(|c| {
            x[c] + h
                * (0.6241109587160757 * k1[c]
                    - 3.3608926294469414 * k4[c]
                    - 0.868219346841726 * k5[c]
                    + 27.59209969944671 * k6[c]
                    + 20.154067550477894 * k7[c]
                    - 43.48988418106996 * k8[c])
        }));
        let k10 = field(&std::array::from_fn(|c| {
            x[c] + h
                * (0.47766253643826434 * k1[c]
                    - 2.4881146199716677 * k4[c]
                    - 0.590290826836843 * k5[c]
                    + 21.230051448181193 * k6[c]
                    + 15.279233632882423 * k7[c]
                    - 33.28821096898486 * k8[c]
                    - 0.020331201708508627 * k9[c])
        }));
        let k11 = field(&std::array::from_fn(|c| {
            x[c] + h
                * (-0.9371424300859873 * k1[c]
                    + 5.186372428844064 * k4[c]
                    + 1.0914373489967295 * k5[c]
                    - 8.149787010746927 * k6[c]
                    - 18.52006565999696 * k7[c]
                    + 22.739487099350505 * k8[c]
                    + 2.4936055526796523 * k9[c]
                    - 3.0467644718982196 * k10[c])
        }));
        let k12 = field(&std::array::from_fn(|c| {
            x[c] + h
                * (2.273310147516538 * k1[c]
                    - 10.53449546673725 * k4[c]
                    - 2.0008720582248625 * k5[c]
                    - 17.9589318631188 * k6[c]
                    + 27.94888452941996 * k7[c]
                    - 2.8589982771350235 * k8[c]
                    - 8.87285693353063 * k9[c]
                    + 12.360567175794303 * k10[c]
                    + 0.6433927460157636 * k11[c])
        }));
        evaluations += 11;
        let slope: [f64; D] = std::array::from_fn(|c| {
            0.054293734116568765 * k1[c] + 4.450312892752409 * k6[c] + 1.8915178993145003 * k7[c]
                - 5.801203960010585 * k8[c]
                + 0.3111643669578199 * k9[c]
                - 0.1521609496625161 * k10[c]
                + 0.20136540080403034 * k11[c]
                + 0.04471061572777259 * k12[c]
        });
        let end: [f64; D] = std::array::from_fn(|c| x[c] + h * slope[c]);
        let (mut fifth, mut third) = (0.0, 0.0);
        for c in 0..D {
            let scale = (tolerance + tolerance * x[c].abs().max(end[c].abs())).recip();
            let error = scale
                * (0.01312004499419488 * k1[c]
                    - 1.2251564463762044 * k6[c]
                    - 0.4957589496572502 * k7[c]
                    + 1.6643771824549864 * k8[c]
                    - 0.35032884874997366 * k9[c]
                    + 0.3341791187130175 * k10[c]
                    + 0.08192320648511571 * k11[c]
                    - 0.022355307863886294 * k12[c]);
            fifth += error * error;
            let error = scale
                * (-0.18980075407240762 * k1[c]
                    + 4.450312892752409 * k6[c]
                    + 1.8915178993145003 * k7[c]
                    - 5.801203960010585 * k8[c]
                    - 0.4226823213237919 * k9[c]
                    - 0.1521609496625161 * k10[c]
                    + 0.20136540080403034 * k11[c]
                    + 0.02265179219836082 * k12[c]);
            third += error * error;
        }
        let below = fifth + 0.01 * third;
        let error = if below > 0.0 {
            h * fifth / (below * D as f64).sqrt()
        } else {
            0.0
        };
        let shrink = error.powf(0.125);
        if error <= 1.0 {
            done = if last { time } else { done + h };
            x = end;
            k1 = field(&x);
            evaluations += 1;
            let next = h / (shrink / 0.9).clamp(1.0 / 6.0, 1.0 / 0.333);
            h = if rejected { next.min(h) } else { next };
            rejected = false;
        } else if error > 1.0 {
            h /= (shrink / 0.9).min(1.0 / 0.333);
            rejected = true;
        } else {
            return None;
        }
    }
    Some((x, evaluations))
}

/// The first step (section II.4): Euler's step of it changes the field by the hundredth part of the state.
#[expect(
    clippy::disallowed_methods,
    reason = "a baseline takes the functions of the platform"
)]
#[inline(always)]
fn first<const D: usize>(
    field: &impl Fn(&[f64; D]) -> [f64; D],
    x: &[f64; D],
    slope: &[f64; D],
    time: f64,
    tolerance: f64,
) -> f64 {
    let size = |values: &[f64; D]| -> f64 {
        let scaled = |c: usize| values[c] / (tolerance + tolerance * x[c].abs());
        (0..D).map(|c| scaled(c) * scaled(c)).sum()
    };
    let (state, speed) = (size(x), size(slope));
    let small = state <= 1e-10 || speed <= 1e-10;
    let guess: f64 = if small {
        1e-6
    } else {
        0.01 * (state / speed).sqrt()
    };
    let guess = guess.min(time);
    let next = field(&std::array::from_fn(|c| x[c] + guess * slope[c]));
    let bend = size(&std::array::from_fn(|c| next[c] - slope[c])).sqrt() / guess;
    let most = bend.max(speed.sqrt());
    let order = if most <= 1e-15 {
        (guess * 1e-3).max(1e-6)
    } else {
        (0.01 / most).powf(0.125)
    };
    (100.0 * guess).min(order).min(time)
}
