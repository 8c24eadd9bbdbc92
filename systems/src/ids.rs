//! The ids of the systems.

/// `$of!("gradient", …)` with every id of the library, in their order.
macro_rules! of_each_system {
    ($of:ident) => {
        $of!(
            "ablowitz-ladik",
            "attitude",
            "camassa-holm",
            "charges",
            "driven-oscillator",
            "driven-pendulum",
            "gradient",
            "gravity",
            "guiding-centre",
            "guiding-centre-cartesian",
            "heavy-top",
            "heavy-top-attitude",
            "kepler",
            "lotka-volterra",
            "lotka-volterra-periodic",
            "magnetic",
            "magnetic-field-line",
            "maxwell-bloch",
            "may-leonard",
            "nambu",
            "planets",
            "point-vortices",
            "restricted-three-body",
            "rigid-body",
            "se3",
            "so4",
            "sphere-vortices",
            "spin-chain",
            "three-wave",
            "toda",
            "volterra-lattice",
            "vortices",
            "vortices-on-sphere"
        );
    };
}
