//! Section 5 of the paper as it is printed: its figures, their settings and the claims about them.
//!
//! A. Cabrera, D. Martín de Diego, M. Vaquero, *Approximating Symplectic Realizations: A General
//! Framework for the Construction of Poisson Integrators*, arXiv:2409.04342.

use serde::Serialize;

/// A figure as the paper describes it.
#[derive(Debug, PartialEq, Serialize)]
pub struct PaperFigure {
    /// Its number.
    #[serde(rename = "figure")]
    pub number: usize,
    /// Its name on the command line.
    #[serde(rename = "name")]
    pub id: &'static str,
    /// The section it stands in.
    pub section: &'static str,
    /// Title of the figure: the quantity that it shows and the case.
    pub title: &'static str,
    /// Setting that the paper gives, and our choice for the part that it leaves open.
    pub setting: &'static str,
    /// Statements of the paper about the figure.
    #[serde(skip)]
    pub claims: &'static [Claim],
}

/// A statement of the paper about a figure.
#[derive(Debug, PartialEq)]
pub struct Claim {
    /// The quantity.
    pub quantity: &'static str,
    /// As printed, shortened.
    pub printed: &'static str,
    /// The number in it.
    pub value: Option<f64>,
}

const REALIZATION_ERROR: &str = "slope of log error against log epsilon, small epsilon";
const TENSOR_ERROR: &str = "slope of the tensor conservation error against epsilon";
const CASIMIR: &str = "largest |C(x_k) - C(x_0)| over the run";
const ENERGY: &str = "largest |H(x_k) - H(x_0)| over the run";

/// The figures of section 5, in the paper's order.
pub const FIGURES: [PaperFigure; 9] = [
    PaperFigure {
        number: 1,
        section: "5.1",
        id: "so3-realization-10",
        title: "realization error on so(3)*, n = 10",
        setting: "The truncated realization of order n = 10 at (x, p) = (2, 3, 3, 1, 2, 3); the \
                  error is that of the brackets, epsilon Pi(alpha) - {alpha, alpha}. Here \
                  derivatives are exact, the paper's are numerical; the paper does not say over \
                  which epsilon it fits.",
        claims: &[
            Claim {
                quantity: REALIZATION_ERROR,
                printed: "approximately 10.99, compared with n + 1 = 11",
                value: Some(10.99),
            },
            Claim {
                quantity: "the error up to epsilon = 0.6",
                printed: "quite small",
                value: None,
            },
        ],
    },
    PaperFigure {
        number: 2,
        section: "5.1",
        id: "so3-realization-4",
        title: "realization error on so(3)*, n = 4",
        setting: "As Figure 1 with n = 4.",
        claims: &[Claim {
            quantity: REALIZATION_ERROR,
            printed: "approximately 4.9, compared with n + 1 = 5",
            value: Some(4.9),
        }],
    },
    PaperFigure {
        number: 3,
        section: "5.1",
        id: "rigid-body",
        title: "Casimir and Hamiltonian of the rigid body",
        setting: "K-HJ with epsilon = 0.1, h = 2, Hamilton-Jacobi to order 2, realization of \
                  order n = 6, from (1, 3, 3). The paper does not say how many steps; here 1000.",
        claims: &[
            Claim {
                quantity: CASIMIR,
                printed: "conservation of order higher than expected theoretically, probably \
                          because the Poisson structure is linear",
                value: None,
            },
            Claim {
                quantity: ENERGY,
                printed: "oscillations of the expected order",
                value: None,
            },
        ],
    },
    PaperFigure {
        number: 4,
        section: "5.1",
        id: "rigid-body-ode45",
        title: "the same with ODE45",
        setting: "Dormand-Prince 5(4) from (1, 3, 3). The paper names no tolerance; here 1e-3 \
                  (the default of MATLAB's ode45), 1e-6 and 1e-9, over the time of Figure 3. \
                  Orders are fitted at fixed steps.",
        claims: &[
            Claim {
                quantity: "order of the Casimir's error",
                printed: "order 5",
                value: Some(5.0),
            },
            Claim {
                quantity: "order of the energy's error",
                printed: "order 5",
                value: Some(5.0),
            },
        ],
    },
    PaperFigure {
        number: 5,
        section: "5.1",
        id: "rigid-body-tensor",
        title: "tensor conservation error of the rigid body, n = 6",
        setting: "The step of Figure 3 with the bisection fixed, S = 2 H, while epsilon varies: \
                  |D phi Pi D phi^T - Pi(phi)|. The paper does not say at which point; here \
                  (1, 3, 3).",
        claims: &[Claim {
            quantity: TENSOR_ERROR,
            printed: "larger than the expected one, which is n + 1 = 7",
            value: None,
        }],
    },
    PaperFigure {
        number: 6,
        section: "5.2",
        id: "lotka-volterra",
        title: "Casimir and Hamiltonian of Lotka-Volterra, epsilon = 0.1",
        setting: "K-HJ with epsilon = 0.1, h = 2, Hamilton-Jacobi to order 2, realization of \
                  order n = 8, from (1, 3, 3). The paper does not say how many steps, nor which \
                  Casimir; here x1 x3 / x2 until the orbit has come within 1e-100 of the edge \
                  of the octant.",
        claims: &[
            Claim {
                quantity: CASIMIR,
                printed: "shown as the evolution of a difference, without a number",
                value: None,
            },
            Claim {
                quantity: ENERGY,
                printed: "shown as the evolution of a difference, without a number",
                value: None,
            },
        ],
    },
    PaperFigure {
        number: 7,
        section: "5.2",
        id: "lotka-volterra-small-epsilon",
        title: "Casimir and Hamiltonian of Lotka-Volterra, epsilon = 0.01",
        setting: "As Figure 6 with epsilon = 0.01, over the same time.",
        claims: &[
            Claim {
                quantity: CASIMIR,
                printed: "a notable increase in accuracy against epsilon = 0.1",
                value: None,
            },
            Claim {
                quantity: ENERGY,
                printed: "a high conservation, similar to the case of epsilon = 0.1",
                value: None,
            },
        ],
    },
    PaperFigure {
        number: 8,
        section: "5.2",
        id: "lotka-volterra-tensor",
        title: "tensor conservation error of Lotka-Volterra, n = 8",
        setting: "As Figure 5, with the setting of Figure 7: n = 8, S = 2 H, at (1, 3, 3).",
        claims: &[Claim {
            quantity: TENSOR_ERROR,
            printed: "slightly larger than 9",
            value: Some(9.0),
        }],
    },
    PaperFigure {
        number: 9,
        section: "5.3",
        id: "magnetic-realization",
        title: "realization error of the magnetic bracket, n = 2",
        setting: "The truncated realization of order n = 2. The paper does not say at which \
                  point; here x = (2, 3, 3, 1, 2, 3), p = (1, 2, 3, 2, 3, 3).",
        claims: &[Claim {
            quantity: REALIZATION_ERROR,
            printed: "3",
            value: Some(3.0),
        }],
    },
];

/// The figure with this number or id.
pub fn find(name: &str) -> Option<&'static PaperFigure> {
    FIGURES.iter().find(|figure| {
        let number = name.strip_prefix("figure-").unwrap_or(name);
        figure.id == name || figure.number.to_string() == number
    })
}
