//! The script of a report in a real browser: Chromium without a window, where there is one.

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use leafwise_report::{Ellipsoid, Recorded, ReportData, TimeSeries, Trajectory, render_report};

const BROWSERS: [&str; 4] = [
    "chromium",
    "chromium-browser",
    "google-chrome",
    "chrome-headless-shell",
];

/// The browser's file: `CHROMIUM`, or one of the usual names on the path.
fn browser() -> Option<PathBuf> {
    if let Some(file) = std::env::var_os("CHROMIUM") {
        return Some(file.into());
    }
    let path = std::env::var_os("PATH")?;
    let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
    let files = BROWSERS
        .iter()
        .flat_map(|name| folders.iter().map(move |f| f.join(name)));
    files.into_iter().find(|file| file.is_file())
}

fn data() -> ReportData {
    let radius = libm::sqrt(19.0);
    let times: Vec<f64> = (0..400).map(|k| 0.25 * f64::from(k)).collect();
    let states: Vec<Vec<f64>> = (times.iter())
        .map(|t| {
            let (a, b) = (0.9 * libm::sin(0.31 * t), 0.31 * t);
            let across = radius * libm::cos(a);
            vec![
                across * libm::cos(b),
                across * libm::sin(b),
                radius * libm::sin(a),
            ]
        })
        .collect();
    let energy = |t: &f64| 10.1 + 1e-6 * libm::sin(*t);
    ReportData {
        title: "A <body> & \"more\"".to_owned(),
        energy: Some(TimeSeries {
            times: times.clone(),
            values: times.iter().map(energy).collect(),
        }),
        recorded: Some(Recorded {
            names: ["t", "x1", "x2", "x3", "energy", "a<b>&\"c\""]
                .map(str::to_owned)
                .to_vec(),
            coordinates: 3,
            rows: (times.iter().zip(&states))
                .map(|(t, x)| [&[*t], x.as_slice(), &[energy(t), f64::NAN]].concat())
                .collect(),
        }),
        trajectory: Some(Trajectory::Orbit {
            names: ["x1", "x2", "x3"].map(str::to_owned).to_vec(),
            times,
            points: states,
            leaf: Some(Ellipsoid {
                center: [0.0; 3],
                semi_axes: [radius; 3],
            }),
        }),
        ..ReportData::default()
    }
}

/// What a script at the end of the page finds out, as its lines.
fn told(browser: &Path, page: &str, driver: &str) -> String {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("report.html");
    let page = page.replace("<head>", &format!("<head><script>{FRAMES}</script>"));
    let own = format!("<script>\n{PRELUDE}\n{driver}\n</script></body>");
    std::fs::write(&file, page.replace("</body>", &own)).expect("writable");
    let run = Command::new(browser)
        .args(["--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"])
        .args(["--window-size=1200,1000", "--virtual-time-budget=20000"])
        .arg(format!(
            "--user-data-dir={}",
            folder.path().join("own").display()
        ))
        .arg(format!("file://{}", file.display()))
        .output()
        .expect("the browser starts");
    let dom = String::from_utf8_lossy(&run.stdout).into_owned();
    let (_, rest) = dom.split_once("<pre id=\"told\">").unwrap_or_else(|| {
        let errors = String::from_utf8_lossy(&run.stderr);
        panic!(
            "the driver has not ended: {errors}\n{}",
            &dom[..dom.len().min(2000)]
        )
    });
    let (told, _) = rest.split_once("</pre>").expect("an end");
    told.replace("&lt;", "<")
        .replace("&gt;", ">")
        .replace("&amp;", "&")
}

/// Without a window a browser draws no frames by itself.
const FRAMES: &str = "window.requestAnimationFrame = (work) => setTimeout(work, 5);";

/// Words for the drivers: events, frames, and what is told in the end.
const PRELUDE: &str = r##"
const lines = [];
const tell = (name, value) => lines.push(`${name}: ${value}`);
window.addEventListener("error", (event) => tell("error", event.message));
const frames = async () => { for (let k = 0; k < 4; k += 1) await new Promise((done) => requestAnimationFrame(done)); };
const send = (canvas, kind, x, y, more = {}) => {
  const box = canvas.getBoundingClientRect();
  canvas.dispatchEvent(new PointerEvent(kind, { bubbles: true, pointerId: 1, clientX: box.left + x, clientY: box.top + y, ...more }));
};
HTMLCanvasElement.prototype.setPointerCapture = () => {};
const key = (canvas, name) => canvas.dispatchEvent(new KeyboardEvent("keydown", { key: name, cancelable: true }));
const saved = [];
const link = HTMLAnchorElement.prototype;
link.click = function () { saved.push([this.download, this.href]); };
const blobs = [];
URL.createObjectURL = (blob) => { blobs.push(blob); return "blob:own"; };
const picture = (canvas) => canvas.toDataURL();
const finish = () => {
  const pre = document.createElement("pre");
  pre.id = "told";
  pre.textContent = lines.join("\n");
  document.body.append(pre);
};
const drive = (work) => work().catch((error) => tell("error", error.stack)).finally(finish);
"##;

const DRIVER: &str = r##"
drive(async () => {
  await frames();
  const [history, orbit] = document.querySelectorAll("canvas");
  const output = orbit.closest("figure").querySelector("output");
  tell("canvases", document.querySelectorAll("canvas").length);
  tell("still orbits", document.querySelectorAll("svg.orbit").length);
  tell("history shown", !history.closest("figure").hidden);
  tell("heading", orbit.closest("figure").querySelector("h3").firstChild.textContent);

  // Turned, and back by Reset to the same pixels.
  const first = picture(orbit);
  send(orbit, "pointerdown", 100, 100, { buttons: 1 });
  send(orbit, "pointermove", 160, 130, { buttons: 1 });
  send(orbit, "pointerup", 160, 130);
  await frames();
  const turned = picture(orbit);
  tell("turned", turned !== first);
  const [reset] = [...orbit.closest("figure").querySelectorAll("button")].filter((one) => one.textContent === "Reset");
  reset.click();
  send(orbit, "pointerleave", 0, 0);
  await frames();
  tell("reset", picture(orbit) === first);
  for (const name of ["ArrowLeft", "ArrowUp"]) { key(orbit, name); await frames(); tell(name, picture(orbit) !== first); reset.click(); await frames(); }
  key(orbit, "+");
  await frames();
  tell("zoomed", picture(orbit) !== first);
  reset.click();

  // The wheel scrolls the page until the picture has been clicked.
  document.activeElement.blur();
  const wheel = () => { const event = new WheelEvent("wheel", { deltaY: -100, cancelable: true, clientX: 300, clientY: 300 }); orbit.dispatchEvent(event); return event.defaultPrevented; };
  tell("wheel passes", !wheel());
  orbit.focus();
  tell("wheel zooms", wheel());
  reset.click();
  await frames();

  // The sample in the middle of the time axis.
  const left = 84, right = history.clientWidth - 16;
  send(history, "pointermove", (left + right) / 2 + 0.001, 100, { buttons: 0 });
  await frames();
  tell("values", output.textContent.replaceAll("\u2212", "-"));
  tell("marked", picture(orbit) !== first);
  send(history, "pointerleave", 0, 0);

  // Any triple, a plane, any quantity.
  const [x, y, z] = orbit.closest("figure").querySelectorAll("select");
  tell("choices", [...x.options].map((one) => one.textContent).join(" "));
  x.value = "4"; x.dispatchEvent(new Event("change"));
  z.value = "0"; z.dispatchEvent(new Event("change"));
  await frames();
  tell("triple", orbit.closest("figure").querySelector("h3").firstChild.textContent);
  const box = picture(orbit);
  z.value = "-1"; z.dispatchEvent(new Event("change"));
  await frames();
  tell("plane", orbit.closest("figure").querySelector("h3").firstChild.textContent + (picture(orbit) !== box));
  const quantity = history.closest("figure").querySelector("select");
  const change = history.closest("figure").querySelector("input");
  const seen = new Set();
  for (const option of quantity.options) {
    quantity.value = option.value;
    quantity.dispatchEvent(new Event("change"));
    await frames();
    seen.add(picture(history));
    tell("change of " + option.textContent, change.checked);
  }
  tell("quantities", seen.size);

  // Files.
  for (const one of document.querySelectorAll("figure button")) if (["SVG", "PNG"].includes(one.textContent)) one.click();
  tell("files", saved.map(([name]) => name).sort().join(" "));
  const drawings = await Promise.all(blobs.filter((blob) => blob.type === "image/svg+xml").map((blob) => blob.text()));
  const read = drawings.map((text) => new DOMParser().parseFromString(text, "image/svg+xml"));
  tell("drawings", read.map((one) => one.querySelectorAll("parsererror").length + " " + (one.querySelectorAll("polyline").length > 5)).join(", "));
  tell("paintings", blobs.filter((blob) => blob.type === "image/png" && blob.size > 1000).length);

  // A page that would fetch something is refused.
  await new Promise((done) => {
    document.addEventListener("securitypolicyviolation", (event) => done(tell("refused", event.violatedDirective)));
    fetch("http://127.0.0.1:9/").catch(() => {});
  });
});
"##;

#[test]
fn a_report_is_turned_zoomed_read_and_saved() {
    let Some(browser) = browser() else {
        // What a test prints is kept from whoever runs it; this is not.
        let mut out = std::io::stderr();
        writeln!(
            out,
            "SKIPPED: no Chromium on the path and no CHROMIUM: the report's script is NOT tested"
        )
        .expect("a stream");
        return;
    };
    let data = data();
    let page = render_report(&data).expect("a page");
    let told = told(&browser, &page, DRIVER);
    let (values, others): (Vec<_>, Vec<_>) =
        told.lines().partition(|line| line.starts_with("values: "));
    let expected = [
        "canvases: 2",
        "still orbits: 0",
        "history shown: true",
        "heading: Orbit in (x1, x2, x3)",
        "turned: true",
        "reset: true",
        "ArrowLeft: true",
        "ArrowUp: true",
        "zoomed: true",
        "wheel passes: true",
        "wheel zooms: true",
        "marked: true",
        "choices: x1 x2 x3 energy a<b>&\"c\" t",
        "triple: Orbit in (energy, x2, t)",
        "plane: Plane (energy, x2)true",
        "change of x1: false",
        "change of x2: false",
        "change of x3: false",
        "change of energy: true",
        "change of a<b>&\"c\": false",
        "quantities: 5",
        "files: a-body-more-a-b-c-over-time.png a-body-more-a-b-c-over-time.svg a-body-more-energy-x2.png \
         a-body-more-energy-x2.svg a-body-more-energy.svg",
        "drawings: 0 true, 0 true, 0 true",
        "paintings: 2",
        "refused: connect-src",
    ];
    assert_eq!(others, expected);
    // The middle of 0 ≤ t ≤ 99.75 is halfway between two samples: to its right t = 50, the 200th, is the nearer one.
    let recorded = data.recorded.expect("states");
    let said: Vec<&str> = values[0]
        .trim_start_matches("values: ")
        .split("   ")
        .collect();
    assert_eq!(said.len(), recorded.names.len());
    for ((said, name), value) in said.iter().zip(&recorded.names).zip(&recorded.rows[200]) {
        let (own, number) = said.split_once(" = ").expect("a name and a number");
        let number: f64 = number.parse().expect("a number");
        assert_eq!(own, name);
        // Ten digits are said.
        let is_near = (number - value).abs() <= 5e-10 * value.abs();
        assert!(
            is_near || number.is_nan() && value.is_nan(),
            "{said} for {value}"
        );
    }
}

/// Draws the quantities over time anew, and tells which words leave the canvas.
const WORDS: &str = r##"
drive(async () => {
  await frames();
  const [history] = document.querySelectorAll("canvas");
  const drawn = [];
  const pens = CanvasRenderingContext2D.prototype;
  const own = pens.fillText;
  pens.fillText = function (words, x, y) {
    const width = this.measureText(words).width;
    const left = x - { left: 0, center: width / 2, right: width }[this.textAlign];
    if (this.canvas === history) drawn.push([words, left, left + width]);
    own.call(this, words, x, y);
  };
  const quantity = history.closest("figure").querySelector("select");
  quantity.dispatchEvent(new Event("change"));
  await frames();
  tell("last", drawn.some(([words]) => words === "200000"));
  tell("cut", drawn.filter(([, left, right]) => left < 0 || right > history.clientWidth).map(([words]) => words).join(" "));
});
"##;

#[test]
fn labels_of_long_times_are_whole() {
    let Some(browser) = browser() else {
        return;
    };
    let mut data = data();
    if let Some(recorded) = &mut data.recorded {
        let last = recorded.rows.len() - 1;
        for (k, row) in recorded.rows.iter_mut().enumerate() {
            row[0] = 2e5 * k as f64 / last as f64;
        }
    }
    let page = render_report(&data).expect("a page");
    assert_eq!(told(&browser, &page, WORDS), "last: true\ncut: ");
}
