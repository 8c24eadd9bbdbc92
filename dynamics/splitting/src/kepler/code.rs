//! Universal variables as straight-line code.

use leafwise_expression::{AnalyticFunction, Arithmetic, Function, Rational, Side, Term};

use crate::sums::{Code, WITHIN};

/// How often the argument z = βs² of Stumpff's functions is quartered: |z| ≤ 4⁵/16 = 64, more than a period's 4π².
const QUARTERINGS: u32 = 5;

/// Largest |z| of a step.
const LARGEST: i64 = 64;

/// Terms of the series, |z| ≤ 1/16: what they leave out is 2/(16⁶ 14!) = 1.4e-18 of c₂.
const TERMS: i64 = 6;

/// Corrections of s, each of the third order. Seven came within 10⁻⁵ of the end from 60 000 states of each of thirteen conics, over
/// times up to a period. Their e were from 0.1 to 10, with 1 ± 10⁻⁸ among them. One more ends it.
const CORRECTIONS: usize = 8;

/// A body's state: x = q − c, p, and the numbers A and B.
pub(super) struct Conic {
    pub(super) place: Vec<Term>,
    pub(super) momentum: Vec<Term>,
    pub(super) rates: [Term; 2],
}

/// r₀, η = x·w with the sign of the time, κ = μ − βr₀, β, and μ.
struct Elements {
    distance: Term,
    eta: Term,
    kappa: Term,
    beta: Term,
    mu: Term,
}

/// The motion at s: t(s) − t, r = dt/ds, dr/ds, G₀, G₁, G₂ and z.
struct Instant {
    excess: Term,
    radius: Term,
    slope: Term,
    g: [Term; 3],
    z: Term,
}

impl Code<'_> {
    /// (Ap, −Bx/|x|³).
    pub(super) fn conic_field(&mut self, conic: &Conic) -> [Vec<Term>; 2] {
        let [a, b] = &conic.rates;
        let square = self.dot(&conic.place, &conic.place);
        let distance = self.function(Function::Sqrt, &square);
        let cube = self.product(&[&square, &distance]);
        let inverse = self.reciprocal(&cube);
        let velocity = conic.momentum.iter().map(|p| self.product(&[a, p]));
        let velocity = velocity.collect();
        let force = conic.place.iter().map(|x| {
            let product = self.product(&[b, x, &inverse]);
            self.0.negate(&product)
        });
        [velocity, force.collect()]
    }

    /// The changes of x and p over the time t.
    pub(super) fn conic(&mut self, conic: &Conic, time: &Term) -> [Vec<Term>; 2] {
        let [a, b] = &conic.rates;
        let sign = self.function(Function::Sign, time);
        let time = self.function(Function::Abs, time);
        let square = self.dot(&conic.place, &conic.place);
        let distance = self.function(Function::Sqrt, &square);
        let inverse = self.reciprocal(&distance);
        let inverse = self.0.whole(&inverse);
        let velocity = conic.momentum.iter().map(|p| self.whole(&[(1, &[a, p])]));
        let velocity: Vec<Term> = velocity.collect();
        let (along, speed) = (
            self.dot(&conic.place, &velocity),
            self.dot(&velocity, &velocity),
        );
        let mu = self.product(&[a, b]);
        let elements = Elements {
            eta: self.whole(&[(1, &[&sign, &along])]),
            kappa: self.whole(&[(1, &[&distance, &speed]), (-1, &[&mu])]),
            beta: self.whole(&[(2, &[&mu, &inverse]), (-1, &[&speed])]),
            distance,
            mu,
        };
        let s = self.universal(&elements, &time);
        // The last correction has the derivatives of what the others, held, converge to: errors of G_k(s + δ) are δ².
        let s = self.0.apply_analytic(AnalyticFunction::HELD, 0, &s);
        let at = self.place(&elements, &time, &s);
        let quotient = self.quotient(&at.excess, &at.radius);
        let delta = self.0.negate(&quotient);
        let refusal = self.refusal(&elements, [&s, &delta], &at);
        let delta = self.whole(&[(1, &[&delta]), (1, &[&refusal])]);
        let [g0, g1, g2] = at.g;
        let (g1, g2) = (
            self.whole(&[(1, &[&g1]), (1, &[&delta, &g0])]),
            self.whole(&[(1, &[&g2]), (1, &[&delta, &g1])]),
        );
        let radius = self.sum(&[(1, &[&at.radius]), (1, &[&delta, &at.slope])]);
        let below = self.reciprocal(&radius);
        let (f, g) = (
            self.whole(&[(-1, &[&elements.mu, &inverse, &g2])]),
            self.whole(&[
                (1, &[&sign, &elements.distance, &g1]),
                (1, &[&sign, &elements.eta, &g2]),
            ]),
        );
        let (f_dot, g_dot) = (
            self.whole(&[(-1, &[b, &sign, &inverse, &below, &g1])]),
            self.whole(&[(-1, &[&elements.mu, &below, &g2])]),
        );
        let both = || conic.place.iter().zip(&velocity).zip(&conic.momentum);
        let place = both().map(|((x, w), _)| self.sum(&[(1, &[&f, x]), (1, &[&g, w])]));
        let place = place.collect();
        let momentum = both().map(|((x, _), p)| self.sum(&[(1, &[&f_dot, x]), (1, &[&g_dot, p])]));
        [place, momentum.collect()]
    }

    /// s with t(s) = t ≥ 0, by Laguerre's corrections for degree 5 within a bracket (B. A. Conway, Celestial Mechanics 39,
    /// 199–211 (1986)).
    ///
    /// t(s) rises. Over at most a period it is shortest on a fall through the centre in the middle of the way. With
    /// Δ = s√β there t = μβ^(−3/2)(Δ − 2 sin(Δ/2)), so that t ≥ μs³/(4π²) for μ > 0. This and |z| ≤ 64 are the upper end
    /// of the bracket.
    fn universal(&mut self, elements: &Elements, time: &Term) -> Term {
        let tiny = self.0.constant(&Rational::new(1, 1_i64 << 62));
        let tiny = (0..4).fold(tiny.clone(), |product, _| self.0.multiply(&product, &tiny));
        let attracts = self.kept(Side::Above, &elements.mu, &elements.mu);
        let below = self.sum(&[(1, &[&attracts]), (1, &[&tiny])]);
        let pi = self.0.pi();
        let above = self.sum(&[(4, &[&pi, &pi, time])]);
        let third = self.0.constant(&Rational::new(1, 3));
        let cube = self.quotient(&above, &below);
        let by_time = (self.0.power(&cube, &third)).expect("a power of a coefficient");
        let size = self.function(Function::Abs, &elements.beta);
        let size = self.sum(&[(1, &[&size]), (1, &[&tiny])]);
        let root = self.function(Function::Sqrt, &size);
        let farthest = self.0.constant(&Rational::from_integer(8));
        let by_angle = self.quotient(&farthest, &root);
        let mut upper = self.smaller(&by_time, &by_angle);
        let mut lower = self.0.zero();
        let straight = self.quotient(time, &elements.distance);
        let most = self.0.scale(&Rational::new(7, 10), &upper);
        let mut s = self.smaller(&straight, &most);
        for _ in 0..CORRECTIONS {
            let at = self.place(elements, time, &s);
            lower = self.either(&at.excess, &lower, &s);
            upper = self.either(&at.excess, &s, &upper);
            let (f, r) = (&at.excess, &at.radius);
            let square = self.sum(&[(16, &[r, r]), (-20, &[f, &at.slope])]);
            let square = self.function(Function::Abs, &square);
            let root = self.function(Function::Sqrt, &square);
            let below = self.sum(&[(1, &[r]), (1, &[&root])]);
            let quotient = self.quotient(f, &below);
            let corrected = self.whole(&[(1, &[&s]), (-5, &[&quotient])]);
            let from_lower = self.sum(&[(1, &[&corrected]), (-1, &[&lower])]);
            let from_upper = self.sum(&[(1, &[&corrected]), (-1, &[&upper])]);
            let outside = self.product(&[&from_lower, &from_upper]);
            let middle = self.sum(&[(1, &[&lower]), (1, &[&upper])]);
            let middle = self.0.scale(&Rational::new(1, 2), &middle);
            let middle = self.0.whole(&middle);
            s = self.either(&outside, &middle, &corrected);
        }
        s
    }

    /// The state at s.
    fn place(&mut self, elements: &Elements, time: &Term, s: &Term) -> Instant {
        let Elements {
            distance,
            eta,
            kappa,
            beta,
            ..
        } = elements;
        let square = self.product(&[s, s]);
        let z = self.whole(&[(1, &[beta, &square])]);
        let [c0, c1, c2, c3] = self.stumpff(&z);
        let g1 = self.whole(&[(1, &[s, &c1])]);
        let g2 = self.whole(&[(1, &[&square, &c2])]);
        let g3 = self.whole(&[(1, &[s, &square, &c3])]);
        Instant {
            excess: self.whole(&[
                (1, &[distance, s]),
                (1, &[eta, &g2]),
                (1, &[kappa, &g3]),
                (-1, &[time]),
            ]),
            radius: self.whole(&[(1, &[distance]), (1, &[eta, &g1]), (1, &[kappa, &g2])]),
            slope: self.whole(&[(1, &[eta, &c0]), (1, &[kappa, &g1])]),
            g: [c0, g1, g2],
            z,
        }
    }

    /// c₀ to c₃ at z, from z/4⁵ by c₀ = 1 − zc₂, c₁ = 1 − zc₃ and c₂(4z) = c₁²/2, c₃(4z) = (c₂ + c₀c₃)/4.
    fn stumpff(&mut self, z: &Term) -> [Term; 4] {
        let one = self.0.one();
        let mut z = self.0.scale(&Rational::new(1, 1 << (2 * QUARTERINGS)), z);
        z = self.0.whole(&z);
        let (mut even, mut odd) = (Vec::new(), Vec::new());
        let mut number = Rational::one();
        for k in 0..TERMS {
            number = &number * &Rational::new(1, 2 * k + 2);
            even.push(self.0.constant(&number));
            number = &number * &Rational::new(1, 2 * k + 3);
            odd.push(self.0.constant(&number));
            number = -number;
        }
        // (2k + 1)! in front of the next.
        let (mut c2, mut c3) = (self.horner(&even, &z), self.horner(&odd, &z));
        let turned =
            |code: &mut Self, z: &Term, c: &Term| code.whole(&[(1, &[&one]), (-1, &[z, c])]);
        for _ in 0..QUARTERINGS {
            let (c0, c1) = (turned(self, &z, &c2), turned(self, &z, &c3));
            let sum = self.sum(&[(1, &[&c2]), (1, &[&c0, &c3])]);
            let quarter = self.0.scale(&Rational::new(1, 4), &sum);
            c3 = self.0.whole(&quarter);
            let half = self.0.scale(&Rational::new(1, 2), &c1);
            c2 = self.whole(&[(1, &[&half, &c1])]);
            z = self.whole(&[(4, &[&z])]);
        }
        [turned(self, &z, &c2), turned(self, &z, &c3), c2, c3]
    }

    /// 0, or NaN, which refuses the step, in three cases:
    ///
    /// - |z| > 64, past a period or e⁸ on a hyperbola;
    /// - the corrections have not ended, or r is so small that s is not known to half of its digits;
    /// - the body passes the centre within the step at a distance below four units of round-off of r₀: a straight fall,
    ///   whose motion ends there.
    fn refusal(&mut self, elements: &Elements, [s, delta]: [&Term; 2], at: &Instant) -> Term {
        let one = self.0.one();
        let most = self.0.constant(&Rational::from_integer(LARGEST * LARGEST));
        let far = self.sum(&[(1, &[&at.z, &at.z]), (-1, &[&most])]);
        let far = self.kept(Side::Above, &far, &one);
        let open = self.sum(&[(1 << 52, &[delta, delta]), (-1, &[s, s])]);
        let open = self.kept(Side::Above, &open, &one);
        // |x × w|² = r₀²|w|² − η² against 2μ times that distance; r₀|w|² = κ + μ.
        let Elements {
            distance,
            eta,
            kappa,
            mu,
            ..
        } = elements;
        let unit = self.0.constant(&Rational::new(1, 1 << 49));
        let falls = self.sum(&[
            (1, &[&unit, mu, distance]),
            (-1, &[distance, kappa]),
            (-1, &[distance, mu]),
            (1, &[eta, eta]),
        ]);
        let falls = self.kept(Side::Above, &falls, &one);
        let out = self.kept(Side::Above, &at.slope, &falls);
        let through = self.kept(Side::Below, eta, &out);
        let flags = self.sum(&[(2, &[&far]), (2, &[&open]), (2, &[&through])]);
        self.0.apply_analytic(WITHIN, 0, &flags)
    }

    fn dot(&mut self, a: &[Term], b: &[Term]) -> Term {
        let products = a.iter().zip(b).map(|(a, b)| (Rational::one(), a, b));
        let products: Vec<_> = products.collect();
        self.0.sum_of_products(&products)
    }

    fn quotient(&mut self, above: &Term, below: &Term) -> Term {
        self.0
            .divide(above, below)
            .expect("it is not 0 as a formula")
    }

    fn kept(&mut self, side: Side, c: &Term, v: &Term) -> Term {
        self.0
            .kept(side, c, v)
            .expect("its condition depends on the state")
    }

    /// a where c > 0, else b.
    fn either(&mut self, c: &Term, a: &Term, b: &Term) -> Term {
        let (above, below) = (self.kept(Side::Above, c, a), self.kept(Side::Below, c, b));
        self.sum(&[(1, &[&above]), (1, &[&below])])
    }

    fn smaller(&mut self, a: &Term, b: &Term) -> Term {
        let difference = self.sum(&[(1, &[b]), (-1, &[a])]);
        self.either(&difference, a, b)
    }
}
