//! The schemes, each a part.

use std::sync::Arc;

use leafwise_core::Pieces;
use leafwise_core::part::{Compared, PartInfo, PartKind};
use leafwise_core::registry::CompositionPart;

use crate::coefficients;
use crate::composed::Composed;
use crate::scheme::{Coefficients, Scheme};

const DOMAIN: &str = "any self-adjoint step map; some stages step backwards in time";
const DOMAIN_OF_FACTORS: &str = "a step map that is a product of a map of order 1 and its adjoint: splitting; some of them step backwards in time";

const DOMAIN_OF_NYSTROM: &str = "splitting into two pieces with {V, {V, {V, T}}} = 0, which the exact algebra proves: H = p²/2 + V(q), kinetic energies quadratic in momenta; some of its flows step backwards in time";
const DOMAIN_OF_PERTURBED: &str = "splitting into two pieces, best where one of them is a small perturbation of the other; some of its flows step backwards in time";

fn part(scheme: Scheme) -> CompositionPart {
    let factors = scheme.takes_factors().then_some(scheme.pieces);
    CompositionPart::new(scheme.info, scheme.order, factors, move |base, given| {
        given.refuse_unknown(scheme.info)?;
        Ok(Arc::new(Composed::new(base, scheme)?))
    })
}

impl Scheme {
    /// The scheme of this name.
    pub fn find(name: &str) -> Option<Self> {
        Self::all().into_iter().find(|s| s.info.name == name)
    }

    /// Every scheme.
    pub fn all() -> [Self; 17] {
        [
            TRIPLE_JUMP,
            SUZUKI_4,
            YOSHIDA_6,
            KAHAN_LI_6,
            KAHAN_LI_8,
            SUZUKI_UMENO_8,
            KAHAN_LI_10,
            SOFRONIOU_SPALETTA_10,
            BLANES_MOAN_4,
            BLANES_MOAN_6,
            NYSTROM_4,
            NYSTROM_6,
            NYSTROM_6_LONG,
            PERTURBED_8_2,
            PERTURBED_10_4,
            PERTURBED_8_6_4,
            PERTURBED_10_6_4,
        ]
    }
}

static TRIPLE_JUMP: Scheme = Scheme {
    info: &PartInfo {
        name: "triple-jump",
        summary: "three stages, the fewest for order 4; large error constants",
        declares: "order 4 over a self-adjoint map of order 2 (3 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN,
        literature: "Yoshida, Construction of higher order symplectic integrators (1990); Forest, Ruth (1990); Creutz, Gocksch (1989); Suzuki (1990)",
        compared: Some(Compared::at(5)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 4,
    pieces: Pieces::Any,
    half: Coefficients::Stages(&coefficients::TRIPLE_JUMP),
};
leafwise_core::built_in!(part(TRIPLE_JUMP));

static SUZUKI_4: Scheme = Scheme {
    info: &PartInfo {
        name: "suzuki-4",
        summary: "Suzuki's fractal: five stages, far smaller error constants than the triple jump",
        declares: "order 4 over a self-adjoint map of order 2 (5 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN,
        literature: "Suzuki, Fractal decomposition of exponential operators (1990)",
        compared: Some(Compared::at(1)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 4,
    pieces: Pieces::Any,
    half: Coefficients::Stages(&coefficients::SUZUKI_4),
};
leafwise_core::built_in!(part(SUZUKI_4));

static YOSHIDA_6: Scheme = Scheme {
    info: &PartInfo {
        name: "yoshida-6",
        summary: "Yoshida's solution A, seven stages",
        declares: "order 6 over a self-adjoint map of order 2 (7 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN,
        literature: "Yoshida, Construction of higher order symplectic integrators (1990), table 1",
        compared: Some(Compared::at(6)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 6,
    pieces: Pieces::Any,
    half: Coefficients::Stages(&coefficients::YOSHIDA_6),
};
leafwise_core::built_in!(part(YOSHIDA_6));

static KAHAN_LI_6: Scheme = Scheme {
    info: &PartInfo {
        name: "kahan-li-6",
        summary: "nine stages, smaller coefficients than solution A",
        declares: "order 6 over a self-adjoint map of order 2 (9 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN,
        literature: "Kahan, Li, Composition constants for raising the orders of unconventional schemes for ordinary differential equations (1997), s9odr6a",
        compared: Some(Compared::at(2)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 6,
    pieces: Pieces::Any,
    half: Coefficients::Stages(&coefficients::KAHAN_LI_6),
};
leafwise_core::built_in!(part(KAHAN_LI_6));

static KAHAN_LI_8: Scheme = Scheme {
    info: &PartInfo {
        name: "kahan-li-8",
        summary: "seventeen stages, small error constants",
        declares: "order 8 over a self-adjoint map of order 2 (17 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN,
        literature: "Kahan, Li (1997), s17odr8a",
        compared: Some(Compared::at(7)),
        reference: Some(&[]),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 8,
    pieces: Pieces::Any,
    half: Coefficients::Stages(&coefficients::KAHAN_LI_8),
};
leafwise_core::built_in!(part(KAHAN_LI_8));

static SUZUKI_UMENO_8: Scheme = Scheme {
    info: &PartInfo {
        name: "suzuki-umeno-8",
        summary: "fifteen stages, the fewest known for order 8",
        declares: "order 8 over a self-adjoint map of order 2 (15 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN,
        literature: "Suzuki, Umeno (1993); McLachlan, On the numerical integration of ordinary differential equations by symmetric composition methods (1995)",
        compared: Some(Compared::at(3)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 8,
    pieces: Pieces::Any,
    half: Coefficients::Stages(&coefficients::SUZUKI_UMENO_8),
};
leafwise_core::built_in!(part(SUZUKI_UMENO_8));

static KAHAN_LI_10: Scheme = Scheme {
    info: &PartInfo {
        name: "kahan-li-10",
        summary: "thirty-one stages, the fewest known for order 10",
        declares: "order 10 over a self-adjoint map of order 2 (31 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN,
        literature: "Kahan, Li (1997), s31odr10a",
        compared: Some(Compared::at(8)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 10,
    pieces: Pieces::Any,
    half: Coefficients::Stages(&coefficients::KAHAN_LI_10),
};
leafwise_core::built_in!(part(KAHAN_LI_10));

static SOFRONIOU_SPALETTA_10: Scheme = Scheme {
    info: &PartInfo {
        name: "sofroniou-spaletta-10",
        summary: "thirty-five stages, error constants far below those of kahan-li-10",
        declares: "order 10 over a self-adjoint map of order 2 (35 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN,
        literature: "Sofroniou, Spaletta, Derivation of symmetric composition constants for symmetric integrators (2005)",
        compared: Some(Compared::at(4)),
        reference: Some(&[]),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 10,
    pieces: Pieces::Any,
    half: Coefficients::Stages(&coefficients::SOFRONIOU_SPALETTA_10),
};
leafwise_core::built_in!(part(SOFRONIOU_SPALETTA_10));

static BLANES_MOAN_4: Scheme = Scheme {
    info: &PartInfo {
        name: "blanes-moan-4",
        summary: "six products of flows forwards and six backwards, tiny error constants",
        declares: "order 4 over splitting (6 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN_OF_FACTORS,
        literature: "Blanes, Moan, Practical symplectic partitioned Runge-Kutta and Runge-Kutta-Nystrom methods, J. Comput. Appl. Math. 142 (2002), S6; as a composition: McLachlan (1995)",
        compared: Some(Compared::at(9)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 4,
    pieces: Pieces::Any,
    half: Coefficients::Factors(&coefficients::BLANES_MOAN_4),
};
leafwise_core::built_in!(part(BLANES_MOAN_4));

static BLANES_MOAN_6: Scheme = Scheme {
    info: &PartInfo {
        name: "blanes-moan-6",
        summary: "ten products of flows forwards and ten backwards, smaller error constants than compositions of stages have",
        declares: "order 6 over splitting (10 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN_OF_FACTORS,
        literature: "Blanes, Moan (2002), S10",
        compared: Some(Compared::at(10)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 6,
    pieces: Pieces::Any,
    half: Coefficients::Factors(&coefficients::BLANES_MOAN_6),
};
leafwise_core::built_in!(part(BLANES_MOAN_6));

static NYSTROM_4: Scheme = Scheme {
    info: &PartInfo {
        name: "nystrom-4",
        summary: "six kicks, made for Hamiltonians p²/2 + V(q): error constants below those of blanes-moan-4",
        declares: "order 4 over splitting (6 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN_OF_NYSTROM,
        literature: "Blanes, Moan, Practical symplectic partitioned Runge-Kutta and Runge-Kutta-Nystrom methods, J. Comput. Appl. Math. 142 (2002), table 3, SRKN6b",
        compared: Some(Compared::at(11)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 4,
    pieces: Pieces::Nystrom { kick_first: true },
    half: Coefficients::Factors(&coefficients::NYSTROM_4),
};
leafwise_core::built_in!(part(NYSTROM_4));

static NYSTROM_6: Scheme = Scheme {
    info: &PartInfo {
        name: "nystrom-6",
        summary: "eleven kicks, made for Hamiltonians p²/2 + V(q)",
        declares: "order 6 over splitting (11 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN_OF_NYSTROM,
        literature: "Blanes, Moan (2002), table 3, SRKN11b",
        compared: Some(Compared::at(12)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 6,
    pieces: Pieces::Nystrom { kick_first: true },
    half: Coefficients::Factors(&coefficients::NYSTROM_6),
};
leafwise_core::built_in!(part(NYSTROM_6));

static NYSTROM_6_LONG: Scheme = Scheme {
    info: &PartInfo {
        name: "nystrom-6-long",
        summary: "fourteen kicks, made for Hamiltonians p²/2 + V(q): smaller error constants a stage than nystrom-6",
        declares: "order 6 over splitting (14 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN_OF_NYSTROM,
        literature: "Blanes, Moan (2002), table 3, SRKN14a",
        compared: Some(Compared::at(13)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 6,
    pieces: Pieces::Nystrom { kick_first: false },
    half: Coefficients::Factors(&coefficients::NYSTROM_6_LONG),
};
leafwise_core::built_in!(part(NYSTROM_6_LONG));

static PERTURBED_8_2: Scheme = Scheme {
    info: &PartInfo {
        name: "perturbed-8-2",
        summary: "four stages: the error of H = A + εB is ε h⁸ + ε² h²",
        declares: "order 2 over splitting (4 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN_OF_PERTURBED,
        literature: "McLachlan, Composition methods in the presence of small parameters, BIT 35 (1995); Laskar, Robutel, High order symplectic integrators for perturbed Hamiltonian systems, Celest. Mech. Dyn. Astron. 80 (2001), SABA4",
        compared: Some(Compared::at(14)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 2,
    pieces: Pieces::Perturbed,
    half: Coefficients::Factors(&coefficients::PERTURBED_8_2),
};
leafwise_core::built_in!(part(PERTURBED_8_2));

static PERTURBED_10_4: Scheme = Scheme {
    info: &PartInfo {
        name: "perturbed-10-4",
        summary: "seven stages: the error of H = A + εB is ε h¹⁰ + ε² h⁴",
        declares: "order 4 over splitting (7 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN_OF_PERTURBED,
        literature: "Blanes, Casas, Farres, Laskar, Makazaga, Murua, New families of symplectic splitting methods for numerical integration in dynamical astronomy, Appl. Numer. Math. 68 (2013), ABA(10,4)",
        compared: Some(Compared::at(15)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 4,
    pieces: Pieces::Perturbed,
    half: Coefficients::Factors(&coefficients::PERTURBED_10_4),
};
leafwise_core::built_in!(part(PERTURBED_10_4));

static PERTURBED_8_6_4: Scheme = Scheme {
    info: &PartInfo {
        name: "perturbed-8-6-4",
        summary: "seven stages: the error of H = A + εB is ε h⁸ + ε² h⁶ + ε³ h⁴",
        declares: "order 4 over splitting (7 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN_OF_PERTURBED,
        literature: "Blanes, Casas, Farres, Laskar, Makazaga, Murua (2013), ABA(8,6,4)",
        compared: Some(Compared::at(16)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 4,
    pieces: Pieces::Perturbed,
    half: Coefficients::Factors(&coefficients::PERTURBED_8_6_4),
};
leafwise_core::built_in!(part(PERTURBED_8_6_4));

static PERTURBED_10_6_4: Scheme = Scheme {
    info: &PartInfo {
        name: "perturbed-10-6-4",
        summary: "eight stages: the error of H = A + εB is ε h¹⁰ + ε² h⁶ + ε³ h⁴",
        declares: "order 4 over splitting (8 stages a step); self-adjoint; Poisson as the map is",
        domain: DOMAIN_OF_PERTURBED,
        literature: "Blanes, Casas, Farres, Laskar, Makazaga, Murua (2013), ABA(10,6,4)",
        compared: Some(Compared::at(17)),
        ..PartInfo::of(PartKind::Composition)
    },
    order: 4,
    pieces: Pieces::Perturbed,
    half: Coefficients::Factors(&coefficients::PERTURBED_10_6_4),
};
leafwise_core::built_in!(part(PERTURBED_10_6_4));
