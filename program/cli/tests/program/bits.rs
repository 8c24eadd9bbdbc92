//! Results have the same bits on registers of any width, interpreted and as machine code.

use crate::support::Place;

/// A system of the library in coordinates with a constant tensor, its stages in eight lanes.
fn scene(library: &str, realization: &str, initial: &str, time_step: f64) -> String {
    format!(
        "[system]\nlibrary = \"{library}\"\n[method]\nrealization = \"{realization}\"\n\
         dynamics = {{ name = \"collective\", stages = 8 }}\ntime-step = {time_step}\n\
         [run]\ninitial = {initial}\nsteps = 500\nrecord = {{ every = 1 }}\n"
    )
}

#[test]
fn samples_have_the_same_bytes_on_registers_of_any_width() {
    let top = scene(
        "heavy-top",
        "clebsch",
        "[0.5, 1.0, 1.5, 0.6, 0.0, 0.8]",
        0.2,
    );
    let species = scene(
        "lotka-volterra-periodic",
        "logarithms",
        "[1, 1.9, 0.5]",
        0.1,
    );
    for scene in [top, species] {
        let here = Place::with(&scene);
        let mut expected = None;
        // On a machine without registers of 512 bits the first two are one.
        for bits in [None, Some("256")] {
            for kernels in ["interpreted", "compiled"] {
                let out = format!("{kernels}-{}", bits.unwrap_or("any"));
                let mut command = here.command(&["run", "scene.toml", "--kernels", kernels]);
                command.args(["--out", &out]).env_remove("LEAFWISE_VECTORS");
                command.envs(bits.map(|bits| ("LEAFWISE_VECTORS", bits)));
                let said = command.output().expect("the program starts");
                assert!(
                    said.status.success(),
                    "{}",
                    String::from_utf8_lossy(&said.stderr)
                );
                let samples = here.read(&format!("{out}/samples.csv"));
                assert_eq!(samples.lines().count(), 502);
                let expected = expected.get_or_insert_with(|| samples.clone());
                assert!(samples == *expected, "{scene}{out}");
            }
        }
    }
}
