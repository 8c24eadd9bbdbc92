//! The schemes, each a part.

use std::sync::Arc;

use leafwise_core::part::{Compared, PartInfo, PartKind};
use leafwise_core::registry::CompositionPart;

use crate::coefficients;
use crate::composed::Composed;
use crate::scheme::{Coefficients, Scheme};

const DOMAIN: &str = "any self-adjoint step map; some stages step backwards in time";
const DOMAIN_OF_FACTORS: &str = "a step map that comes apart into a map of order 1 and its adjoint: splitting; some of them step backwards in time";

fn part(scheme: Scheme) -> CompositionPart {
    let takes_factors = scheme.takes_factors();
    CompositionPart::new(
        scheme.info,
        scheme.order,
        takes_factors,
        move |base, given| {
            given.refuse_unknown(scheme.info)?;
            Ok(Arc::new(Composed::new(base, scheme)?))
        },
    )
}

impl Scheme {
    /// The scheme of this name.
    pub fn find(name: &str) -> Option<Self> {
        Self::all().into_iter().find(|s| s.info.name == name)
    }

    /// Every scheme.
    pub fn all() -> [Self; 10] {
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
    half: Coefficients::Factors(&coefficients::BLANES_MOAN_6),
};
leafwise_core::built_in!(part(BLANES_MOAN_6));
