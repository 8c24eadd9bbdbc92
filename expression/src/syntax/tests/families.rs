use super::super::{At, Boundary, SyntaxErrorKind, VariablePattern};
use super::*;

/// u[0] … u[4] at 1 … 5 and v[0] … v[3] at 6 … 9, behind the scalar s at 0.
fn lattice(boundary: Boundary) -> Scope {
    Scope::new()
        .with_variables(&["s"])
        .with_family("u", 1, 5)
        .with_family("v", 6, 4)
        .with_parameters(&["k"])
        .with_boundary(boundary)
}

/// The state whose entries are their own indices.
const STATE: [f64; 10] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];

fn at(text: &str, boundary: Boundary, index: Option<At<'_>>) -> Option<f64> {
    let resolved = parse(text).resolve(&lattice(boundary), index);
    let expression = resolved.unwrap_or_else(|error| panic!("{text}: {error}"));
    expression.map(|expression| expression.evaluate(&STATE, &[100.0]))
}

#[test]
fn periodic_references_wrap_at_the_length_of_their_own_family() {
    let periodic = |text, value| at(text, Boundary::Periodic, Some((&["i"], value)));
    assert_eq!(periodic("u[i+1]", 3), Some(5.0));
    assert_eq!(periodic("u[i+1]", 4), Some(1.0));
    assert_eq!(periodic("u[i-2]", 0), Some(4.0));
    assert_eq!(periodic("v[i]", 4), Some(6.0));
    assert_eq!(periodic("sum(j, u[j+1])", 0), Some(15.0));
}

/// Which way round an offset of more than half goes is no longer what its sign says: it is refused at every site, with the offset of the
/// same site.
#[test]
fn offsets_beyond_half_of_a_ring_name_axis_offset_and_length() {
    let mut refused = 0;
    for length in 1..=12_i64 {
        let ring = Scope::new().with_family("u", 0, length as usize);
        let members: Vec<f64> = (0..length).map(|site| site as f64).collect();
        // A piece of a longer ring looks as far as that.
        let piece = ring.clone().with_rings(&[100]);
        for offset in (-40..=40_i64).filter(|offset| *offset != 0) {
            let text = format!("u[i{offset:+}]");
            let value = |scope: &Scope, text: &str, site: usize| {
                let resolved = parse(text).resolve(scope, Some((&["i"], site)));
                resolved.map(|found| found.expect("a ring").evaluate(&members, &[]))
            };
            for site in 0..length {
                let expected = (site + offset).rem_euclid(length) as f64;
                let site = site as usize;
                assert_eq!(value(&piece, &text, site), Ok(expected));
                if offset.abs() <= (length / 2).max(1) {
                    assert_eq!(value(&ring, &text, site), Ok(expected));
                    continue;
                }
                refused += 1;
                let error = value(&ring, &text, site).expect_err(&text);
                let kind = SyntaxErrorKind::OffsetBeyondHalf {
                    axis: 0,
                    offset,
                    length: length as usize,
                };
                assert_eq!((error.kind, error.span), (kind, 2..text.len() - 1));
                // The suggestion is the same site, and is taken.
                let same = format!("u[{}]", error.suggestion.expect("a suggestion"));
                assert_eq!(value(&ring, &same, site), Ok(expected), "{text} {same}");
            }
        }
    }
    assert!(refused > 5000, "{refused}");
    let (plane, _) = plane(&[Boundary::Periodic, Boundary::Open]);
    let error = parse("w[i+2,j+9]")
        .resolve(&plane, Some((&["i", "j"], 0)))
        .expect_err("three sites along i");
    assert_eq!(
        error.to_string(),
        "the offset 2 along axis 0 is beyond half of a ring of 3 sites; did you mean `i-1`?"
    );
}

#[test]
fn open_references_make_their_term_absent() {
    let open = |text, value| at(text, Boundary::Open, Some((&["i"], value)));
    assert_eq!(open("u[i]*u[i+1]", 3), Some(20.0));
    assert_eq!(open("u[i]*u[i+1]", 4), None);
    assert_eq!(open("1 + u[i-1]", 0), None);
    assert_eq!(open("v[i]", 4), None);
}

#[test]
fn a_sum_drops_the_summands_that_its_own_index_takes_outside() {
    let open = |text| at(text, Boundary::Open, Some((&["i"], 4)));
    let neighbours = 1.0 * 2.0 + 2.0 * 3.0 + 3.0 * 4.0 + 4.0 * 5.0;
    assert_eq!(open("sum(j, u[j]*u[j+1])"), Some(neighbours));
    assert_eq!(open("s + sum(j, v[j])"), Some(30.0));
    // j = 4 is dropped as a whole; k runs over its own sites.
    assert_eq!(
        open("sum(j, sum(k, u[j+1]*u[k]))"),
        Some((2.0 + 3.0 + 4.0 + 5.0) * 15.0)
    );
    // The free index reaches outside, whatever j is.
    assert_eq!(open("sum(j, u[j]*u[i+1])"), None);
    assert_eq!(open("sum(j, u[j+7])"), Some(0.0));
}

/// What a summand is multiplied or divided by is carried to its terms, whatever it is, as long as it stays inside.
#[test]
fn equal_products_lose_the_same_terms_at_an_open_end() {
    let open = |text: &str| at(text, Boundary::Open, None).expect("a value");
    let inner: f64 = (1..=5).map(|u| f64::from(u * u)).sum();
    let ahead: f64 = (2..=5).map(|u| f64::from(u * u)).sum();
    for text in [
        "sum(j, 3*(u[j]^2 + u[j+1]^2))",
        "sum(j, (u[j]^2 + u[j+1]^2)*3)",
        "sum(j, 6*(u[j]^2 + u[j+1]^2)/2)",
        "3*sum(j, (u[j]^2 + u[j+1]^2)^1)",
        "3*sum(j, u[j]^2) + 3*sum(j, u[j+1]^2)",
        "sum(j, -3*(-(u[j]^2) - u[j+1]^2))",
    ] {
        assert_eq!(open(text), 3.0 * (inner + ahead), "{text}");
    }
    let products: f64 = (1..=5).map(|u| f64::from(u * u)).sum::<f64>() + 2.0 + 6.0 + 12.0 + 20.0;
    for text in [
        "sum(j, u[j]*(u[j] + u[j+1]))",
        "sum(j, (u[j] + u[j+1])*u[j])",
        "sum(j, u[j]^2 + u[j]*u[j+1])",
        "sum(j, (u[j]^3 + u[j]^2*u[j+1])/u[j])",
        "sum(j, u[j]*(-(-u[j] - u[j+1])/1))",
    ] {
        assert_eq!(open(text), products, "{text}");
    }
    // A power, a function, a product of two that reach outside, and what is divided by it, are one term.
    let springs = 4.0;
    for text in [
        "sum(j, (u[j+1] - u[j])^2)",
        "sum(j, (u[j+1] - u[j])*(u[j+1] - u[j]))",
        "sum(j, sqrt((u[j+1] - u[j])^2))",
        "sum(j, (u[j+1] - u[j] + 0*u[j])/(u[j+1] - u[j]))",
    ] {
        assert_eq!(open(text), springs, "{text}");
    }
    // By way of an outer index too.
    assert_eq!(
        open("sum(j, sum(k, u[k] + u[j+1]))"),
        5.0 * 15.0 + 5.0 * 14.0
    );
    assert_eq!(open("sum(j, sum(k, u[k]*u[j+1]))"), 14.0 * 15.0);
    // On a ring nothing is outside.
    let ring = at("sum(j, u[j]*(u[j] + u[j+1]))", Boundary::Periodic, None);
    assert_eq!(ring, Some(products + 5.0));
}

#[test]
fn what_is_left_out_is_told_as_it_is_written() {
    let formula =
        parse("sum(j, u[j]^2 + 3*(v[j]^2 + (u[j+1] - u[j])^2)/2) + sum(j, u[j]*(u[j-1] + u[j+2]))");
    let left_out = |boundary, site| formula.left_out(&lattice(boundary), site).expect("sums");
    assert_eq!(left_out(Boundary::Open, 0), ["u[j-1]"]);
    assert_eq!(left_out(Boundary::Open, 1), [""; 0]);
    assert_eq!(left_out(Boundary::Open, 3), ["u[j+2]"]);
    assert_eq!(
        left_out(Boundary::Open, 4),
        ["3*(v[j]^2 + (u[j+1] - u[j])^2)/2", "u[j+2]"]
    );
    assert_eq!(left_out(Boundary::Periodic, 4), [""; 0]);
}

#[test]
fn fixed_sites_are_counted_from_both_ends() {
    for boundary in [Boundary::Periodic, Boundary::Open] {
        assert_eq!(
            at("u[0] + 10*u[N-1] + 100*v[3]", boundary, None),
            Some(951.0)
        );
        assert_eq!(at("u[N-2-1+1]", boundary, None), Some(4.0));
    }
}

#[test]
fn the_length_shown_may_differ_from_the_sites_in_scope() {
    let scope = lattice(Boundary::Periodic).with_length(1024);
    let value = |text: &str| {
        let expression = parse(text)
            .resolve(&scope, None)
            .expect("names")
            .expect("no boundary");
        expression.evaluate(&STATE, &[])
    };
    assert_eq!(value("N"), 1024.0);
    assert_eq!(value("u[N-1]"), 5.0);
    assert_eq!(value("sum(i, u[i])/N"), 15.0 / 1024.0);
}

#[test]
fn values_take_the_index_as_a_number() {
    let scope = lattice(Boundary::Periodic).with_length(8);
    let formula = parse("k + 0.5*sin(2*pi*i/N)");
    for site in 0..8usize {
        let angle = 2.0 * std::f64::consts::PI * site as f64 / 8.0;
        let expected = 3.0 + 0.5 * libm::sin(angle);
        assert_eq!(
            formula.value(&scope, &[3.0], Some((&["i"], site))),
            Ok(expected)
        );
    }
    let sum = parse("sum(j, j*i)").value(&scope, &[], Some((&["i"], 2)));
    assert_eq!(sum, Ok(20.0));
}

#[test]
fn the_free_index_is_the_one_no_sum_introduces() {
    for (text, free) in [
        ("u[i+1]*v[i]", &["i"][..]),
        ("sum(i, u[i])", &[]),
        ("sum(j, u[j]*u[i])", &["i"]),
        ("sum(j, u[j]) + u[j]", &["j"]),
        ("u[0] + i", &[]),
        ("w[j, i+1]*w[i,j]", &["j", "i"]),
        ("sum(i, w[i,k])", &["", "k"]),
        ("w[0,k]*w[i,0]", &["i", "k"]),
    ] {
        assert_eq!(parse(text).free_indices(), free, "{text}");
    }
    let names = |text: &str| {
        let formula = parse(text);
        formula
            .references()
            .into_iter()
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    assert_eq!(names("sum(j, j*u[j]*k) + i*v[i] + w"), ["k", "u", "v", "w"]);
    assert_eq!(names("sum(j, u[j]) + j"), ["j", "u"]);
}

#[test]
fn patterns_lead_to_indices_of_the_state() {
    let one = |text| VariablePattern::parse_one(text).expect("a variable");
    let open = lattice(Boundary::Open);
    let periodic = lattice(Boundary::Periodic);
    for (text, index, in_open, in_periodic) in [
        ("s", 0, Some(0), Some(0)),
        ("u[i]", 2, Some(3), Some(3)),
        ("u[i+1]", 4, None, Some(1)),
        ("v[ i - 1 ]", 0, None, Some(9)),
        ("v[2]", 0, Some(8), Some(8)),
        ("u[N-1]", 0, Some(5), Some(5)),
    ] {
        let at = Some((&["i"][..], index));
        assert_eq!(one(text).resolve(&open, at), Ok(in_open), "{text}");
        assert_eq!(one(text).resolve(&periodic, at), Ok(in_periodic), "{text}");
    }
    let pattern = one("v[ m - 1 ]");
    assert_eq!((pattern.name(), pattern.index_names()), ("v", vec!["m"]));
    let offsets = pattern
        .offsets_from(&["m"])
        .expect("an index")
        .expect("a family");
    assert_eq!(
        (offsets.axes()[0].clone(), pattern.to_string().as_str()),
        (-1..=-1, "v[m-1]")
    );
    assert!(one("u[3]").index_names().is_empty());
    assert!(one("u[3]").offsets_from(&[]).is_err());
}

#[test]
fn patterns_that_lead_nowhere_are_refused_at_their_place() {
    let scope = lattice(Boundary::Open);
    let text = "u[i],w[i+1]";
    let (first, second) = VariablePattern::parse_pair(text).expect("a pair");
    assert_eq!(first.resolve(&scope, Some((&["i"], 1))), Ok(Some(2)));
    let error = second.resolve(&scope, Some((&["i"], 1))).expect_err("no w");
    assert_eq!(&text[error.span.clone()], "w");
    let parameter = VariablePattern::parse_one("k").expect("a name");
    let kind = SyntaxErrorKind::NotAVariable {
        name: "k".to_owned(),
    };
    assert_eq!(
        parameter
            .resolve(&scope, None)
            .expect_err("a parameter")
            .kind,
        kind
    );
    for text in [
        "u[i]",
        "u[i],",
        "u[i] v[i]",
        "u[i],v[i],s",
        "1,2",
        "u+1,v",
        ",",
        "sin,u",
        "",
    ] {
        assert!(VariablePattern::parse_pair(text).is_err(), "{text}");
    }
    for text in ["u[i],v[i]", "2*s", "u[i]^2", "pi", "-s", "s)"] {
        assert!(VariablePattern::parse_one(text).is_err(), "{text}");
    }
}

/// The sum over pairs: what the double sum counts twice, without its diagonal.
#[test]
fn sums_over_pairs_take_each_once() {
    let sum = |text| at(text, Boundary::Periodic, None).expect("a value");
    let pairs: f64 = (1..=5)
        .flat_map(|i| (i + 1..=5).map(move |j| f64::from(i * j * j)))
        .sum();
    assert_eq!(sum("sum(i<j, u[i]*u[j]^2)"), pairs);
    assert_eq!(
        2.0 * sum("sum(i<j, u[i]*u[j])") + sum("sum(i, u[i]^2)"),
        sum("sum(i, sum(j, u[i]*u[j]))")
    );
    assert_eq!(
        parse("sum( i <j , u[i]*u[j])").to_string(),
        "sum(i<j, u[i]*u[j])"
    );
    let of_numbers = parse("sum(i<j, 10*i + j)").value(&lattice(Boundary::Open), &[], None);
    let by_hand: i32 = (0..5)
        .flat_map(|i| (i + 1..5).map(move |j| 10 * i + j))
        .sum();
    assert_eq!(of_numbers, Ok(f64::from(by_hand)));
    for (text, kind) in [
        ("sum(i<i, u[i])", "DuplicateIndex"),
        ("sum(i<, u[i])", "Expected"),
        ("1 < 2", "Expected"),
    ] {
        let error = refusal(text, &lattice(Boundary::Open));
        assert!(
            format!("{:?}", error.kind).contains(kind),
            "{text}: {error:?}"
        );
    }
}

/// A component of a vector is a family with a point in its name.
#[test]
fn components_have_names_with_a_point() {
    let scope = Scope::new()
        .with_family("s.x", 0, 2)
        .with_family("s.y", 2, 2);
    let value = |text: &str| {
        let resolved = parse(text).resolve(&scope, Some((&["i"], 1)));
        let expression = resolved.expect("known names").expect("inside");
        expression.evaluate(&[3.0, 5.0, 7.0, 11.0], &[])
    };
    assert_eq!(value("s.x[i]*s.y[i+1] - 2.*s.x[0]"), 29.0);
    assert_eq!(Scope::check_name("s.x"), Ok(()));
    for text in ["s.", "s.1", "s.x.y", ".x"] {
        assert!(Scope::check_name(text).is_err(), "{text}");
    }
    let error = refusal("s.z[0]", &scope);
    assert!(
        matches!(error.kind, SyntaxErrorKind::UnknownName { .. }),
        "{error:?}"
    );
}

/// w of 3 × 4 sites, w[i,j] = 10·i + j.
fn plane(boundaries: &[Boundary]) -> (Scope, Vec<f64>) {
    let state = (0..12).map(|at| f64::from(at / 4 * 10 + at % 4)).collect();
    let scope = Scope::new()
        .with_lattice("w", 0, &[3, 4])
        .with_boundaries(boundaries);
    (scope, state)
}

/// Members of a plane by two sites, wrapping or ending along each axis by itself.
#[test]
fn planes_have_an_index_an_axis() {
    let value = |text: &str, boundaries: &[Boundary], site: usize| {
        let (scope, state) = plane(boundaries);
        let here = Some((&["i", "j"][..], site)).filter(|_| !text.contains("sum"));
        let resolved = parse(text).resolve(&scope, here);
        let resolved = resolved.unwrap_or_else(|error| panic!("{text}: {error}"));
        resolved.map(|resolved| resolved.evaluate(&state, &[]))
    };
    let (around, open) = (Boundary::Periodic, Boundary::Open);
    // Site 11 is i = 2, j = 3.
    for (text, boundaries, expected) in [
        ("w[i,j]", [around, around], Some(23.0)),
        ("w[i+1,j+2]", [around, around], Some(1.0)),
        ("w[i+1,j]", [open, around], None),
        ("w[i,j+1]", [open, around], Some(20.0)),
        ("w[i,j+1]", [around, open], None),
        ("w[N-1,N-1] - w[0,N-2]", [open, open], Some(21.0)),
        ("w[1,j]", [open, open], Some(13.0)),
    ] {
        assert_eq!(value(text, &boundaries, 11), expected, "{text}");
    }
    let whole: f64 = (0..12).map(|at| f64::from(at / 4 * 10 + at % 4)).sum();
    for text in [
        "sum(i, j, w[i,j])",
        "sum(j, i, w[i,j])",
        "sum(i, sum(j, w[i+1,j-1]))",
    ] {
        assert_eq!(value(text, &[around, around], 0), Some(whole), "{text}");
    }
    // Bonds along each axis of an open plane: 2·4 and 3·3.
    let bonds = "sum(i, j, (w[i,j] - w[i+1,j])^2/100 + (w[i,j] - w[i,j+1])^2)";
    assert_eq!(value(bonds, &[open, open], 0), Some(17.0));
    assert_eq!(value("sum(j, w[1,j])", &[open, open], 0), Some(46.0));
    // Pairs i < j along one axis, sums over several indices as they are printed.
    let pairs = "sum(i<k, j, w[i,j]*w[k,j])";
    assert_eq!(parse(pairs).to_string(), pairs);
    let by_hand: f64 = (0..4)
        .map(|j| f64::from(j * (10 + j) + j * (20 + j) + (10 + j) * (20 + j)))
        .sum();
    assert_eq!(value(pairs, &[open, open], 0), Some(by_hand));
}

/// A site's share of a sum over a plane; all shares together are the sum.
#[test]
fn densities_of_planes_add_up() {
    for boundaries in [
        [Boundary::Open, Boundary::Periodic],
        [Boundary::Periodic, Boundary::Open],
        [Boundary::Open; 2],
    ] {
        let (scope, state) = plane(&boundaries);
        for text in [
            "sum(i, j, w[i,j]*w[i+1,j] + w[i,j-1]*w[i,j])",
            "2*sum(j, i, w[i,j]*w[i+1,j]) - sum(i, j, w[i,j-1]*w[i,j]/2)",
        ] {
            let formula = parse(text);
            let whole = formula
                .resolve(&scope, None)
                .expect("names")
                .expect("inside");
            let shares = (0..12).map(|site| {
                let density = formula.density(&scope, site).expect("a sum over sites");
                density.site.evaluate(&state, &[])
            });
            assert_eq!(shares.sum::<f64>(), whole.evaluate(&state, &[]), "{text}");
        }
    }
    let (scope, _) = plane(&[Boundary::Open; 2]);
    for (text, message) in [
        (
            "sum(i, w[i,0])",
            "the lattice has 2 axes, and the sum 1 index:",
        ),
        (
            "sum(i, j, w[i,i])",
            "the index `i` counts along an axis of 3 sites and along one of 4",
        ),
        (
            "sum(i, j, k, w[i,j])",
            "the lattice has 2 axes, and the sum 3 indices: write one an axis, `sum(i, j, …)`",
        ),
    ] {
        let refused = parse(text).density(&scope, 0).expect_err(text);
        assert!(
            refused.to_string().starts_with(message),
            "{text}: {refused}"
        );
    }
}

/// What does not fit the axes of a family is said.
#[test]
fn planes_refuse_what_does_not_fit_their_axes() {
    let (scope, _) = plane(&[Boundary::Periodic; 2]);
    for (text, message) in [
        (
            "w[1]",
            "`w` has 2 axes, and 1 is written here: write `w[i,j]`",
        ),
        (
            "w[1,2,0]",
            "`w` has 2 axes, and 3 are written here: write `w[i,j]`",
        ),
        ("w[1,4]", "`w` has the sites 0 to 3 along axis 1, not 4"),
        ("sum(i, 1)", "the index `i` counts along no axis"),
        (
            "sum(i, w[i,i])",
            "the index `i` counts along an axis of 3 sites and along one of 4",
        ),
        ("w[0,0]/N", "`N` as a number"),
        (
            "sum(i<j, w[i,j])",
            "the indices `i` < `j` count along different axes",
        ),
        (
            "sum(i, j, w[i,j]*w[j,0])",
            "the index `j` counts along an axis of 4 sites and along one of 3",
        ),
    ] {
        let error = refusal(text, &scope);
        assert!(error.to_string().starts_with(message), "{text}: {error}");
    }
}
