//! Claims about reports.

mod other_pages;

use super::*;

fn sample(count: usize) -> (Vec<f64>, Vec<Vec<f64>>) {
    let times: Vec<_> = (0..count).map(|k| 0.2 * k as f64).collect();
    let radius = libm::sqrt(19.0);
    let points = times
        .iter()
        .map(|t| {
            let (a, b) = (0.9 * libm::sin(0.31 * t), 0.31 * t);
            let across = libm::cos(a);
            vec![
                radius * across * libm::cos(b),
                radius * across * libm::sin(b),
                radius * libm::sin(a),
            ]
        })
        .collect();
    (times, points)
}

fn noise(k: usize) -> f64 {
    let mixed = (k as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 40;
    mixed as f64 / (1u64 << 24) as f64
}

fn rigid_body(count: usize) -> ReportData {
    let (times, points) = sample(count);
    let energy: Vec<_> = times
        .iter()
        .map(|t| 10.1 + 2e-5 * libm::sin(0.4 * t) * libm::sin(0.4 * t))
        .collect();
    let energy_drift = energy.iter().map(|value| value - 10.1).collect();
    let energy_values = energy.clone();
    let spin = (0..count)
        .map(|k| {
            if k < 12 {
                0.0
            } else {
                3.5e-15 * (0.05 + noise(k))
            }
        })
        .collect();
    ReportData {
        advice: Vec::new(),
        observables: Vec::new(),
        work: None,
        title: "Rigid body <so(3)*> & \"friends\"".to_owned(),
        version: "leafwise 0.1.0".to_owned(),
        command: "leafwise run rigid_body.toml --set 'method.epsilon=0.1'".to_owned(),
        scene_name: "rigid_body.toml".to_owned(),
        scene_text: "[system]\nlibrary = \"rigid-body\" # 1 < 2 & <script>\n\n[method]\n\
                     realization = { name = \"karasev-truncated\", order = 2 }\n\
                     dynamics = { name = \"hamilton-jacobi\", order = 2 }\n\
                     epsilon = 0.1\nh = 2.0\n\n[run]\ninitial = [1, 3, 3]\nsteps = 1000\n"
            .to_owned(),
        outcome: Outcome::Done {
            message: "1000 steps to t = 200 in 0.004 s".to_owned(),
        },
        method: vec![
            (
                "Realization".to_owned(),
                "karasev-truncated, n = 2: α̂ = x + (ε/2)π♯p + …".to_owned(),
            ),
            (
                "Dynamic approximation".to_owned(),
                "hamilton-jacobi, m = 2: Ŝ = h S₁".to_owned(),
            ),
            (
                "Combined order in t = εh".to_owned(),
                "2 (declared, a lower bound)".to_owned(),
            ),
        ],
        facts: vec![
            ("Steps".to_owned(), "1000 of εh = 0.2".to_owned()),
            ("Evaluations per step".to_owned(), "3.02".to_owned()),
            ("Integration time".to_owned(), "0.004 s".to_owned()),
            ("Run directory".to_owned(), "runs/rigid_body".to_owned()),
        ],
        invariants: vec![
            InvariantSeries {
                name: "energy".to_owned(),
                reference: 10.1,
                times: times.clone(),
                deviations: energy_drift,
            },
            InvariantSeries {
                name: "spin".to_owned(),
                reference: 19.0,
                times: times.clone(),
                deviations: spin,
            },
        ],
        logarithmic_time: false,
        drift_every: 1,
        energy: Some(TimeSeries {
            times: times.clone(),
            values: energy,
        }),
        section: Some(SectionPoints {
            title: "x1 = 0, upwards".to_owned(),
            names: ["x2".to_owned(), "x3".to_owned()],
            points: vec![[1.0, 2.0], [-1.0, f64::NAN], [2.0, 1.0], [0.5, -1.5]],
            members: Vec::new(),
        }),
        trajectory: Some(Trajectory::Orbit {
            names: ["x1", "x2", "x3"].map(str::to_owned).to_vec(),
            times: times.clone(),
            points: points.clone(),
            leaf: Some(Ellipsoid {
                center: [0.0; 3],
                semi_axes: [libm::sqrt(19.0); 3],
            }),
        }),
        recorded: Some(Recorded {
            names: ["t", "x1", "x2", "x3", "energy"]
                .map(str::to_owned)
                .to_vec(),
            coordinates: 3,
            rows: (times.iter().zip(&points).zip(&energy_values))
                .map(|((t, x), energy)| [&[*t][..], x, &[*energy]].concat())
                .collect(),
        }),
        structure: Vec::new(),
        solver: Some(TimeSeries {
            values: (0..count)
                .map(|k| if k % 7 == 0 { 4.0 } else { 3.0 })
                .collect(),
            times,
        }),
    }
}

fn lattice() -> ReportData {
    let times: Vec<_> = (0..80).map(|k| 0.5 * k as f64).collect();
    let wave = |i: usize, t: f64| {
        let s = (i as f64 - 1.3 * t).rem_euclid(128.0) - 40.0;
        1.0 + 2.0 / (libm::cosh(0.2 * s) * libm::cosh(0.2 * s))
    };
    let fields: Vec<Vec<f64>> = times
        .iter()
        .map(|t| (0..128).map(|i| wave(i, *t)).collect())
        .collect();
    ReportData {
        title: "Volterra lattice".to_owned(),
        trajectory: Some(Trajectory::Lattice {
            name: "x".to_owned(),
            times,
            spacing: 1,
            fields,
            has_neighbours: true,
        }),
        ..rigid_body(200)
    }
}

fn failed() -> ReportData {
    let mut data = rigid_body(300);
    data.outcome = Outcome::Failed {
        message: "the solver did not converge: residual 3.1e-2 after 50 evaluations".to_owned(),
        step: 270,
        time: 54.0,
        state: vec![("x1".to_owned(), 6.1e-25), ("x2".to_owned(), f64::NAN)],
        hint: "a smaller time step, or realization = \"log-canonical\"".to_owned(),
    };
    data.logarithmic_time = true;
    data.invariants[0].deviations[280] = f64::NAN;
    data.invariants[1].deviations[290] = f64::INFINITY;
    if let Some(energy) = &mut data.energy {
        energy.values[280..].fill(f64::NAN);
    }
    if let Some(Trajectory::Orbit { points, leaf, .. }) = &mut data.trajectory {
        points[299][1] = f64::NAN;
        *leaf = None;
    }
    data
}

fn page(data: &ReportData) -> String {
    render_report(data).expect("a report")
}

/// Checks that every tag is closed in order.
fn assert_well_formed(html: &str) {
    let html = without_script(html);
    let mut open: Vec<&str> = Vec::new();
    for piece in html.split('<').skip(1) {
        let (tag, _) = piece.split_once('>').expect("every tag ends");
        let name = tag.split([' ', '\n']).next().unwrap_or("");
        match name.strip_prefix('/') {
            Some(closed) => assert_eq!(open.pop(), Some(closed)),
            None if name.starts_with('!') || name == "meta" || tag.ends_with('/') => {}
            None => open.push(name),
        }
    }
    assert!(open.is_empty(), "left open: {open:?}");
}

/// The page without its program, whose `<` are no tags.
fn without_script(html: &str) -> String {
    let Some((before, rest)) = html.split_once("<script>") else {
        return html.to_owned();
    };
    let (_, after) = rest.split_once("</script>").expect("a script ends");
    format!("{before}{after}")
}

fn all() -> Vec<ReportData> {
    vec![rigid_body(1001), lattice(), failed(), ReportData::default()]
}

#[test]
fn pages_are_well_formed() {
    for data in all() {
        assert_well_formed(&page(&data));
    }
}

#[test]
fn pages_fetch_nothing() {
    for data in all() {
        let html = page(&data).replace("xmlns=\"http://www.w3.org/2000/svg\"", "");
        for outside in [
            "http:",
            "https:",
            "src=",
            "href=",
            "@import",
            "url(",
            "fetch(",
            "XMLHttp",
            "import(",
            "WebSocket",
        ] {
            assert!(!html.contains(outside), "{outside} occurs");
        }
        // And a browser is told to fetch nothing, whatever a page may ask for.
        assert!(html.contains("content=\"default-src 'none';"));
        assert!(!html.contains("connect-src"));
    }
}

/// Every picture of a page that carries states is there without them, and its own script is the only one.
#[test]
fn pages_are_readable_without_their_script() {
    let data = rigid_body(400);
    let still = ReportData {
        recorded: None,
        ..rigid_body(400)
    };
    let (html, still) = (page(&data), page(&still));
    assert_eq!(
        html.matches("<svg ").count(),
        still.matches("<svg ").count() + 1
    );
    assert_eq!(html.matches("<script").count(), 2);
    assert!(!still.contains("<script"));
    let (_, history) = html
        .split_once("<figure class=\"history\"")
        .expect("a figure");
    assert!(history.starts_with(" hidden>"));
}

/// The numbers within a page are the recorded ones to the bit; of too many, every so many and the last.
#[test]
fn a_page_carries_its_states() {
    for (count, stride) in [(1001, 1), (50_000, 6)] {
        let data = rigid_body(count);
        let html = page(&data);
        let (_, rest) = html.split_once("data-axes=\"1 2 3\"").expect("axes");
        let (_, rest) = rest.split_once('>').expect("a tag");
        let (text, _) = rest.split_once('<').expect("an end");
        assert!(text.len() < 600_000);
        let recorded = data.recorded.expect("states");
        let last = recorded.rows.len() - 1;
        let mut kept: Vec<_> = recorded.rows.iter().step_by(stride).collect();
        kept.extend((!last.is_multiple_of(stride)).then(|| &recorded.rows[last]));
        let numbers = decoded(text);
        assert_eq!(numbers.len(), 5 * kept.len());
        for (at, value) in numbers.iter().enumerate() {
            let expected = kept[at % kept.len()][at / kept.len()];
            assert_eq!(value.to_bits(), expected.to_bits());
        }
        assert_eq!(html.contains("One state of 6 is in the page"), stride == 6);
    }
}

fn decoded(text: &str) -> Vec<f64> {
    let six_bits = |letter: u8| match letter {
        b'A'..=b'Z' => letter - b'A',
        b'a'..=b'z' => letter - b'a' + 26,
        b'0'..=b'9' => letter - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let mut bytes = Vec::new();
    for group in text.trim_end_matches('=').as_bytes().chunks(4) {
        let bits = group.iter().fold(0u32, |bits, letter| {
            bits << 6 | u32::from(six_bits(*letter))
        });
        let bits = bits << (6 * (4 - group.len()));
        bytes.extend_from_slice(&bits.to_be_bytes()[1..group.len()]);
    }
    let (numbers, rest) = bytes.as_chunks::<8>();
    assert!(rest.is_empty());
    numbers
        .iter()
        .map(|bytes| f64::from_le_bytes(*bytes))
        .collect()
}

#[test]
fn special_characters_are_text() {
    let html = page(&rigid_body(50));
    assert!(html.contains("Rigid body &lt;so(3)*&gt; &amp; &quot;friends&quot;"));
    assert!(html.contains("# 1 &lt; 2 &amp; &lt;script&gt;"));
    assert!(html.contains("<td>runs/rigid_body</td>"));
}

#[test]
fn values_that_are_not_finite_are_reported_and_never_drawn() {
    let html = page(&failed());
    assert!(html.contains("energy is not finite from t = 56 on"));
    assert!(html.contains("Not finite: 20 of 300 values, the first at t = 56"));
    assert!(html.contains("Not finite and not drawn: 1 of 300 states"));
    assert!(html.contains("x2 = NaN"));
    for piece in html.split("points=\"").skip(1) {
        let points = piece.split('"').next().unwrap_or("");
        assert!(!points.contains("NaN") && !points.contains("inf"));
    }
}

#[test]
fn a_section_is_drawn_as_a_dot_for_each_crossing() {
    let html = page(&rigid_body(50));
    let (_, figure) = html
        .split_once("Section x1 = 0, upwards in (x2, x3)")
        .expect("a figure");
    let (figure, rest) = figure.split_once("</svg>").expect("a picture");
    assert_eq!(figure.matches("<circle").count(), 3);
    assert!(rest.contains("Not finite and not drawn: 1 of 4 crossings."));
}

/// Paths of bodies stand before all other figures.
#[test]
fn paths_of_bodies_stand_first() {
    let body = |number: usize| BodyPath {
        name: format!("vortex <{number}>"),
        number,
        places: vec![[0.0, number as f64], [1.0, 0.5], [2.0, 2.0]],
    };
    let html = page(&ReportData {
        trajectory: Some(Trajectory::Bodies {
            axes: ["x", "y"].map(str::to_owned),
            bodies: (0..9).map(body).collect(),
            count: 9,
        }),
        ..rigid_body(50)
    });
    assert_well_formed(&html);
    let figures: Vec<&str> = html.split("<h3>").skip(1).collect();
    assert!(figures[0].starts_with("Trajectories in (x, y)"));
    assert!(figures[1].starts_with("Drift"));
    // Six names in the colours of the series, and three in colours of their own.
    assert_eq!(figures[0].matches("style=\"--key: #").count(), 3);
    assert!(figures[0].contains("vortex &lt;8&gt;"));
}

#[test]
fn exact_zeros_are_drawn_at_the_floor_and_counted() {
    assert!(page(&rigid_body(400)).contains("the deviation is exactly zero, drawn at 1×10⁻¹⁷"));
}

#[test]
fn a_long_run_stays_under_a_megabyte() {
    let size = page(&rigid_body(200_000)).len();
    assert!(size < 1 << 20, "{size} bytes");
    let size = page(&lattice()).len();
    assert!(size < 1 << 20, "{size} bytes");
}

#[test]
fn an_orbit_that_fills_its_picture_stays_small() {
    let mut data = rigid_body(100);
    let points = (0..300_000)
        .map(|k| vec![noise(k), noise(k * k), noise(k * k * k)])
        .collect();
    data.trajectory = Some(Trajectory::Orbit {
        names: ["a", "b", "c"].map(str::to_owned).to_vec(),
        times: (0..300_000).map(f64::from).collect(),
        points,
        leaf: None,
    });
    let html = page(&data);
    let dots = html.matches("<circle").count();
    assert!((1000..=6004).contains(&dots), "{dots} dots");
    assert!(html.len() < 1 << 20, "{} bytes", html.len());
}

#[test]
fn growth_compares_the_last_tenth_with_the_first() {
    let html = page(&ReportData {
        invariants: vec![InvariantSeries {
            name: "c".to_owned(),
            reference: 0.0,
            times: (0..20).map(f64::from).collect(),
            deviations: (1..=20).map(f64::from).collect(),
        }],
        ..ReportData::default()
    });
    assert!(html.contains("<td class=\"number\">20</td><td class=\"number\">–</td>"));
    assert!(html.contains("<td class=\"number\">10</td></tr>"));
}

#[test]
fn degenerate_data_gives_a_page() {
    let extremes = [
        0.0,
        -0.0,
        5e-324,
        1.0,
        f64::MAX,
        -f64::MAX,
        f64::NAN,
        f64::INFINITY,
    ];
    for value in extremes {
        for count in [0, 1, 2, 30] {
            let times: Vec<_> = (0..count).map(|k| value * f64::from(k)).collect();
            let series = TimeSeries {
                times: times.clone(),
                values: vec![value; count as usize],
            };
            let drift = InvariantSeries {
                name: "c".to_owned(),
                reference: value,
                times: times.clone(),
                deviations: vec![value; 1 + count as usize],
            };
            for dimension in 0..5 {
                let orbit = Trajectory::Orbit {
                    names: vec!["x".to_owned(); dimension],
                    times: times.clone(),
                    points: vec![vec![value; dimension]; count as usize],
                    leaf: Some(Ellipsoid {
                        center: [value; 3],
                        semi_axes: [value; 3],
                    }),
                };
                let lattice = Trajectory::Lattice {
                    name: "x".to_owned(),
                    times: times.clone(),
                    spacing: count as usize,
                    fields: vec![vec![value; dimension]; count as usize],
                    has_neighbours: dimension % 2 == 0,
                };
                for trajectory in [orbit, lattice] {
                    let html = page(&ReportData {
                        invariants: vec![drift.clone()],
                        logarithmic_time: dimension % 2 == 0,
                        drift_every: 1,
                        energy: Some(series.clone()),
                        solver: Some(series.clone()),
                        trajectory: Some(trajectory),
                        ..ReportData::default()
                    });
                    assert_well_formed(&html);
                }
            }
        }
    }
}
