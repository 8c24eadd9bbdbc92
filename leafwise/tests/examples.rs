//! Every example of `leafwise/examples` runs, and holds what it asserts.

macro_rules! examples {
    ($($name:ident $path:literal),*) => {
        $(
            #[path = $path]
            mod $name;
        )*

        $(
            #[test]
            fn $name() {
                $name::main().expect("it runs");
            }
        )*

        #[test]
        fn none_is_left_out() {
            let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/examples");
            let files = std::fs::read_dir(folder).expect("the examples");
            assert_eq!(files.count(), [$($path),*].len());
        }
    };
}

examples! {
    scene "../examples/01_scene.rs",
    code "../examples/02_code.rs",
    observer "../examples/03_observer.rs",
    ensemble "../examples/04_ensemble.rs",
    realization "../examples/05_realization.rs",
    comparison "../examples/06_comparison.rs",
    checks "../examples/07_checks.rs",
    resuming "../examples/08_resuming.rs",
    gradient "../examples/09_gradient.rs"
}
