//! `--basis` and `--degree`: functions of each variable.

use leafwise::learn::{BasisAxis, BasisDegree, FunctionFamily};
use leafwise::scene::ComposedRun;
use leafwise::scene::compose::{TensorShape, tensor_shape};

use crate::failure::Failure;

/// The basis of every variable: `--basis [VARIABLE=]FAMILY[:PERIOD][+ln]`, and `family` where none is named.
pub(in crate::commands) fn axes(
    basis: &[String],
    family: FunctionFamily,
    run: &ComposedRun,
    names: &[String],
) -> Result<Vec<BasisAxis>, Failure> {
    let is_log_canonical = tensor_shape(&run.system) == TensorShape::LogCanonical;
    let default = BasisAxis {
        family,
        has_logarithm: is_log_canonical,
    };
    let mut axes = vec![default; names.len()];
    for given in basis {
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
                format!("--basis {given} is not a basis"),
                "write polynomial, centred, spline, exponential, fourier, fourier:PERIOD, or with logarithms polynomial+ln; for one variable q=fourier",
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
            None if family == "centred" => FunctionFamily::Centred,
            None if family == "spline" => FunctionFamily::Spline,
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

/// `--degree D`, or a degree for each variable: `--degree q=14,p=8`.
pub(in crate::commands) fn degree(
    given: Option<&str>,
    names: &[String],
) -> Result<Option<BasisDegree>, Failure> {
    let Some(given) = given else {
        return Ok(None);
    };
    let unknown = |reason: String| {
        Failure::usage(
            format!("--degree {given}: {reason}"),
            format!(
                "write a number, or one for each variable: {}",
                names
                    .iter()
                    .map(|name| format!("{name}=4"))
                    .collect::<Vec<_>>()
                    .join(",")
            ),
        )
    };
    let number = |text: &str| {
        let number = text.trim().parse::<usize>();
        number.map_err(|_| unknown(format!("`{}` is no degree", text.trim())))
    };
    if !given.contains('=') {
        return number(given).map(|degree| Some(BasisDegree::Total(degree)));
    }
    let mut degrees = vec![None; names.len()];
    for part in given.split(',') {
        let (name, degree) = part
            .split_once('=')
            .ok_or_else(|| unknown(format!("`{part}` names no variable")))?;
        let at = names.iter().position(|known| known == name.trim());
        let at =
            at.ok_or_else(|| unknown(format!("the scene has no variable `{}`", name.trim())))?;
        if degrees[at].is_some() {
            return Err(unknown(format!("{} has a degree already", names[at])));
        }
        degrees[at] = Some(number(degree)?);
    }
    let missing = degrees.iter().position(Option::is_none);
    match missing {
        Some(at) => Err(unknown(format!("{} has no degree", names[at]))),
        None => Ok(Some(BasisDegree::Each(
            degrees.into_iter().flatten().collect(),
        ))),
    }
}
