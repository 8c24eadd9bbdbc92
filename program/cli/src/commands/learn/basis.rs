//! `--basis`: functions of each variable.

use leafwise::learn::{BasisAxis, FunctionFamily};
use leafwise::scene::ComposedRun;
use leafwise::scene::compose::{TensorShape, tensor_shape};

use crate::arguments::LearnArguments;
use crate::failure::Failure;

/// The basis of every variable: `--basis [VARIABLE=]FAMILY[:PERIOD][+ln]`.
pub(super) fn axes(
    arguments: &LearnArguments,
    run: &ComposedRun,
    names: &[String],
) -> Result<Vec<BasisAxis>, Failure> {
    let is_log_canonical = tensor_shape(&run.system) == TensorShape::LogCanonical;
    let default = BasisAxis {
        family: FunctionFamily::Polynomial,
        has_logarithm: is_log_canonical,
    };
    let mut axes = vec![default; names.len()];
    for given in &arguments.basis {
        let (places, family) = match given.split_once('=') {
            None => (0..names.len(), given.as_str()),
            Some((name, family)) => {
                let at = names.iter().position(|known| known == name.trim());
                let at = at.ok_or_else(|| {
                    Failure::usage(
                        format!(
                            "--basis {given}: the scene has no variable `{}`",
                            name.trim()
                        ),
                        format!("name one of {}", names.join(", ")),
                    )
                })?;
                (at..at + 1, family)
            }
        };
        let unknown = || {
            Failure::usage(
                format!("--basis {given} is no basis"),
                "write polynomial, exponential, fourier, fourier:PERIOD, or with logarithms polynomial+ln; for one variable q=fourier",
            )
        };
        let (family, has_logarithm) = match family.trim().strip_suffix("+ln") {
            Some(family) => (family, true),
            None => (family.trim(), false),
        };
        let family = match family.split_once(':') {
            Some(("fourier", period)) => FunctionFamily::Fourier {
                period: period.parse().map_err(|_| unknown())?,
            },
            None if family == "polynomial" => FunctionFamily::Polynomial,
            None if family == "exponential" => FunctionFamily::Exponential,
            None if family == "fourier" => FunctionFamily::Fourier {
                period: std::f64::consts::TAU,
            },
            _ => return Err(unknown()),
        };
        for at in places {
            axes[at] = BasisAxis {
                family,
                has_logarithm,
            };
        }
    }
    Ok(axes)
}
