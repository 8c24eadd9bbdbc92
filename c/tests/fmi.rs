//! Functional mock-up units: the file as its standard has it, and the library called as a simulator calls it.

use std::ffi::{CStr, CString, c_char, c_void};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;

use leafwise::core::Registry;
use leafwise::scene::{ComposedRun, SceneDocument, compose};
use leafwise_cli::console::Console;
use libloading::{Library, Symbol};

const BODY: &str = "[system]\nvariables = [\"x1\", \"x2\", \"x3\"]\nparameters = { I1 = 1.0, I2 = 0.75, I3 = 1.25 }\n\
    bracket = { lie-algebra = \"so3\" }\nhamiltonian = \"x1^2/(2*I1) + x2^2/(2*I2) + x3^2/(2*I3)\"\n\
    casimirs = { spin = \"x1^2 + x2^2 + x3^2\" }\n[method]\nrealization = \"auto\"\n\
    dynamics = { name = \"hamilton-jacobi\", order = 4 }\ntime-step = 0.05\n[run]\ninitial = [1, 3, 3]\nsteps = 1000\n";

type Pointer = *mut c_void;
type LogMessage = unsafe extern "C" fn(*mut c_void, i32, *const c_char, *const c_char);

fn library() -> PathBuf {
    let own = std::env::current_exe().expect("a program has a file");
    let folder = own.parent().expect("a file has a folder");
    let name = |prefix: &str| format!("{prefix}leafwise_c{}", std::env::consts::DLL_SUFFIX);
    folder.join(name(std::env::consts::DLL_PREFIX))
}

/// What the program says about arguments.
fn program(arguments: &[&str]) -> (u8, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let code = {
        let mut console = Console::new(&mut out, &mut err, false, false);
        let given = std::iter::once("leafwise").chain(arguments.iter().copied());
        leafwise_cli::run(
            given.map(Into::into),
            &mut console,
            &Arc::new(AtomicBool::new(false)),
        )
    };
    let said = [out, err].concat();
    (code, String::from_utf8_lossy(&said).into_owned())
}

/// The unit of a scene, as its entries by name.
fn unit(folder: &Path, scene: &str) -> Vec<(String, Vec<u8>)> {
    let [file, out] = ["scene.toml", "body.fmu"].map(|name| folder.join(name));
    std::fs::write(&file, scene).expect("a writable folder");
    let library = library();
    let paths = [&file, &library, &out].map(|path| path.to_str().expect("UTF-8"));
    let (code, said) = program(&["fmu", paths[0], "--library", paths[1], "--out", paths[2]]);
    assert_eq!(code, 0, "{said}");
    entries(&std::fs::read(&out).expect("it was written"))
}

/// The entries of an archive, by its directory.
fn entries(bytes: &[u8]) -> Vec<(String, Vec<u8>)> {
    let number = |at: usize, size: usize| {
        let digits = bytes[at..at + size].iter().rev();
        digits.fold(0, |sum, digit| (sum << 8) | usize::from(*digit))
    };
    let end = bytes.len() - 22;
    assert_eq!(&bytes[end..end + 4], b"PK\x05\x06");
    let (count, mut at) = (number(end + 10, 2), number(end + 16, 4));
    let mut found = Vec::new();
    for _ in 0..count {
        assert_eq!(&bytes[at..at + 4], b"PK\x01\x02");
        let (size, length, place) = (number(at + 24, 4), number(at + 28, 2), number(at + 42, 4));
        let name = String::from_utf8(bytes[at + 46..at + 46 + length].to_vec()).expect("a name");
        assert_eq!(&bytes[place..place + 4], b"PK\x03\x04");
        // Both descriptions of an entry are the same.
        assert_eq!(bytes[place + 4..place + 28], bytes[at + 6..at + 30]);
        let content = place + 30 + length;
        found.push((name, bytes[content..content + size].to_vec()));
        at += 46 + length;
    }
    assert_eq!(at, end);
    found
}

static SAID: Mutex<Vec<String>> = Mutex::new(Vec::new());

/// Tests that log take turns.
static TURN: Mutex<()> = Mutex::new(());

unsafe extern "C" fn log(
    environment: *mut c_void,
    status: i32,
    category: *const c_char,
    message: *const c_char,
) {
    assert_eq!((environment.addr(), status), (7, 3));
    // SAFETY: strings end with a NUL.
    let [category, message] = [category, message].map(|text| unsafe { CStr::from_ptr(text) });
    assert_eq!(category, c"logStatusError");
    SAID.lock()
        .expect("no panic")
        .push(message.to_string_lossy().into_owned());
}

/// The library of a unit, as a simulator loads it.
struct Simulator {
    library: Library,
    resources: tempfile::TempDir,
    token: String,
}

impl Simulator {
    fn new(scene: &str) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let entries = unit(folder.path(), scene);
        let of = |name: &str| {
            let found = entries.iter().find(|(own, _)| own.contains(name));
            &found.expect("an entry").1
        };
        let described = String::from_utf8(of("modelDescription.xml").clone()).expect("UTF-8");
        let token = described
            .split("instantiationToken=\"")
            .nth(1)
            .expect("a token");
        let token = token.split('"').next().expect("its end").to_owned();
        let resources = tempfile::tempdir().expect("a folder");
        std::fs::write(resources.path().join("scene.toml"), of("resources/")).expect("writable");
        let within = folder.path().join("unit");
        std::fs::write(&within, of("binaries/")).expect("writable");
        // SAFETY: the library initialises nothing when it is loaded.
        let library = unsafe { Library::new(&within) }.expect("a library");
        Self {
            library,
            resources,
            token,
        }
    }

    /// Calls a function of the library.
    fn function<T>(&self, name: &str) -> Symbol<'_, T> {
        // SAFETY: the types of the calls below are those of the standard.
        unsafe { self.library.get(name.as_bytes()) }
            .unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    fn instance(&self, token: &str) -> Pointer {
        type Instantiate = unsafe extern "C" fn(
            *const c_char,
            *const c_char,
            *const c_char,
            bool,
            bool,
            bool,
            bool,
            *const u32,
            usize,
            Pointer,
            Option<LogMessage>,
            Option<unsafe extern "C" fn()>,
        ) -> Pointer;
        let call: Symbol<'_, Instantiate> = self.function("fmi3InstantiateCoSimulation");
        let resources = format!("{}/", self.resources.path().display());
        let [token, resources] =
            [token, &resources].map(|text| CString::new(text).expect("no NUL"));
        let environment = std::ptr::without_provenance_mut(7);
        // SAFETY: strings end with a NUL, and the function to log with is there.
        unsafe {
            call(
                c"body".as_ptr(),
                token.as_ptr(),
                resources.as_ptr(),
                false,
                false,
                false,
                false,
                std::ptr::null(),
                0,
                environment,
                Some(log),
                None,
            )
        }
    }

    fn plain(&self, name: &str, instance: Pointer) -> i32 {
        let call: Symbol<'_, unsafe extern "C" fn(Pointer) -> i32> = self.function(name);
        // SAFETY: the function takes an instance.
        unsafe { call(instance) }
    }

    fn enter(&self, instance: Pointer, start: f64) -> i32 {
        type Enter = unsafe extern "C" fn(Pointer, bool, f64, f64, bool, f64) -> i32;
        let call: Symbol<'_, Enter> = self.function("fmi3EnterInitializationMode");
        // SAFETY: no pointers beside the instance.
        unsafe { call(instance, false, 0.0, start, false, 0.0) }
    }

    fn get(&self, instance: Pointer, numbers: &[u32]) -> (i32, Vec<f64>) {
        type Get = unsafe extern "C" fn(Pointer, *const u32, usize, *mut f64, usize) -> i32;
        let call: Symbol<'_, Get> = self.function("fmi3GetFloat64");
        let mut values = vec![0.0; numbers.len()];
        // SAFETY: both arrays are as long as they are said to be.
        let status = unsafe {
            call(
                instance,
                numbers.as_ptr(),
                numbers.len(),
                values.as_mut_ptr(),
                values.len(),
            )
        };
        (status, values)
    }

    fn set(&self, instance: Pointer, numbers: &[u32], values: &[f64]) -> i32 {
        type Set = unsafe extern "C" fn(Pointer, *const u32, usize, *const f64, usize) -> i32;
        let call: Symbol<'_, Set> = self.function("fmi3SetFloat64");
        // SAFETY: both arrays are as long as they are said to be.
        unsafe {
            call(
                instance,
                numbers.as_ptr(),
                numbers.len(),
                values.as_ptr(),
                values.len(),
            )
        }
    }

    fn step(&self, instance: Pointer, time: f64, step: f64) -> (i32, f64) {
        type Step = unsafe extern "C" fn(
            Pointer,
            f64,
            f64,
            bool,
            *mut bool,
            *mut bool,
            *mut bool,
            *mut f64,
        ) -> i32;
        let call: Symbol<'_, Step> = self.function("fmi3DoStep");
        let (mut flags, mut last) = ([true; 3], f64::NAN);
        let [event, terminate, early] = &mut flags;
        // SAFETY: all places may be written.
        let status = unsafe {
            call(
                instance,
                time,
                step,
                true,
                event,
                terminate,
                early,
                &raw mut last,
            )
        };
        assert_eq!(flags, [false; 3]);
        (status, last)
    }

    fn free(&self, instance: Pointer) {
        let call: Symbol<'_, unsafe extern "C" fn(Pointer)> = self.function("fmi3FreeInstance");
        // SAFETY: the function takes an instance.
        unsafe { call(instance) }
    }
}

fn said() -> String {
    let mut said = SAID.lock().expect("no panic");
    let last = said.pop().unwrap_or_default();
    said.clear();
    last
}

fn composed(text: &str) -> ComposedRun {
    let registry = Registry::with_builtin();
    let document = SceneDocument::parse("body", text, &registry).expect("a scene");
    compose(&document, &registry).expect("a method")
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

/// State, energy and Casimir after every so many steps.
fn samples(text: &str, every: u64, count: usize) -> Vec<Vec<f64>> {
    let run = composed(text);
    let (mut walk, mut invariants) = (run.walk(), run.invariants().expect("code"));
    let sample = |_| {
        walk.advance(every).expect("a regular motion");
        let mut values = vec![0.0; 2];
        invariants.evaluate(walk.state(), &mut values);
        [walk.state(), &values].concat()
    };
    (0..count).map(sample).collect()
}

const OUTPUTS: [u32; 5] = [4, 5, 6, 7, 8];

#[test]
fn a_unit_steps_with_the_bits_of_the_program() {
    let _turn = TURN.lock().expect("no panic");
    let simulator = Simulator::new(BODY);
    let instance = simulator.instance(&simulator.token);
    assert!(!instance.is_null(), "{}", said());
    assert_eq!(simulator.enter(instance, 2.0), 0);
    assert_eq!(
        simulator.get(instance, &[0, 1, 2, 3, 4, 5, 6]),
        (0, vec![2.0, 1.0, 0.75, 1.25, 1.0, 3.0, 3.0])
    );
    assert_eq!(simulator.plain("fmi3ExitInitializationMode", instance), 0);
    let mut time = 2.0;
    for expected in samples(BODY, 4, 100) {
        // A simulator adds up its steps.
        assert_eq!(simulator.step(instance, time, 0.2).0, 0, "{}", said());
        time += 0.2;
        let (status, found) = simulator.get(instance, &OUTPUTS);
        assert_eq!((status, bits(&found)), (0, bits(&expected)));
    }
    let (_, now) = simulator.get(instance, &[0]);
    assert!((now[0] - 22.0).abs() < 1e-12, "{now:?}");
    assert_eq!(simulator.plain("fmi3Terminate", instance), 0);
    // Again with other parameters and another state.
    assert_eq!(simulator.plain("fmi3Reset", instance), 0);
    assert_eq!(
        simulator.set(instance, &[2, 4], &[0.5, 1.5]),
        0,
        "{}",
        said()
    );
    assert_eq!(simulator.enter(instance, 0.0), 0);
    assert_eq!(simulator.plain("fmi3ExitInitializationMode", instance), 0);
    let (status, last) = simulator.step(instance, 0.0, 0.05);
    assert_eq!((status, last), (0, 0.05));
    let other = BODY
        .replace("I2 = 0.75", "I2 = 0.5")
        .replace("[1, 3, 3]", "[1.5, 3, 3]");
    let (_, found) = simulator.get(instance, &OUTPUTS);
    assert_eq!(bits(&found), bits(&samples(&other, 1, 1)[0]));
    simulator.free(instance);
    assert_eq!(simulator.get(instance, &[0]).0, 3);
}

#[test]
fn misuse_is_an_error_with_its_reason() {
    let _turn = TURN.lock().expect("no panic");
    let simulator = Simulator::new(BODY);
    assert!(simulator.instance("{other}").is_null());
    assert!(said().contains("export the unit again"));
    let instance = simulator.instance(&simulator.token);
    let mut cases = 0;
    let mut refused = |status: i32, reason: &str| {
        let told = said();
        assert!(
            status == 3 && told.contains(reason),
            "{status} {told} {reason}"
        );
        cases += 1;
    };
    refused(
        simulator.step(instance, 0.0, 0.05).0,
        "not allowed in the mode Instantiated",
    );
    refused(
        simulator.plain("fmi3ExitInitializationMode", instance),
        "not allowed",
    );
    refused(simulator.enter(instance, f64::NAN), "startTime is NaN");
    assert_eq!(simulator.enter(instance, 0.0), 0);
    refused(
        simulator.set(instance, &[7], &[1.0]),
        "energy cannot be set",
    );
    refused(
        simulator.set(instance, &[4], &[f64::NAN]),
        "not a finite number",
    );
    refused(
        simulator.set(instance, &[4, 9], &[1.0, 1.0]),
        "there is no variable 9",
    );
    refused(
        simulator.get(instance, &[77]).0,
        "there is no variable 77: the unit has 9",
    );
    assert_eq!(simulator.get(instance, &[4]), (0, vec![1.0]));
    assert_eq!(simulator.plain("fmi3ExitInitializationMode", instance), 0);
    refused(
        simulator.step(instance, 0.0, 0.07).0,
        "not a multiple of the scene's time-step, 0.05",
    );
    for step in [0.0, -0.05, f64::NAN, f64::INFINITY] {
        refused(simulator.step(instance, 0.0, step).0, "not a multiple");
    }
    refused(simulator.step(instance, 1.0, 0.05).0, "the unit is at 0");
    refused(
        simulator.set(instance, &[4], &[2.0]),
        "not allowed in the mode Step",
    );
    refused(
        simulator.plain("fmi3EnterEventMode", instance),
        "fmi3EnterEventMode is not offered",
    );
    assert_eq!(simulator.step(instance, 0.0, 0.05).0, 0);
    simulator.free(instance);
    simulator.free(instance);
    simulator.free(std::ptr::null_mut());
    assert_eq!(cases, 15);
}

/// The names of the standard's `fmi3Functions.h`: a simulator looks up all of them.
#[test]
fn every_function_of_the_standard_is_there() {
    const PLAIN: &str = "GetVersion SetDebugLogging InstantiateModelExchange InstantiateCoSimulation InstantiateScheduledExecution \
        FreeInstance EnterInitializationMode ExitInitializationMode EnterEventMode Terminate Reset GetNumberOfVariableDependencies \
        GetVariableDependencies GetFMUState SetFMUState FreeFMUState SerializedFMUStateSize SerializeFMUState DeserializeFMUState \
        GetDirectionalDerivative GetAdjointDerivative EnterConfigurationMode ExitConfigurationMode GetIntervalDecimal \
        GetIntervalFraction GetShiftDecimal GetShiftFraction SetIntervalDecimal SetIntervalFraction SetShiftDecimal SetShiftFraction \
        EvaluateDiscreteStates UpdateDiscreteStates EnterContinuousTimeMode CompletedIntegratorStep SetTime SetContinuousStates \
        GetContinuousStateDerivatives GetEventIndicators GetContinuousStates GetNominalsOfContinuousStates GetNumberOfEventIndicators \
        GetNumberOfContinuousStates EnterStepMode GetOutputDerivatives DoStep ActivateModelPartition";
    const TYPES: &str = "Float32 Float64 Int8 UInt8 Int16 UInt16 Int32 UInt32 Int64 UInt64 Boolean String Binary Clock";
    // SAFETY: the library initialises nothing when it is loaded.
    let library = unsafe { Library::new(library()) }.expect("a library");
    let typed = TYPES
        .split_whitespace()
        .flat_map(|name| [format!("Get{name}"), format!("Set{name}")]);
    let names: Vec<String> = PLAIN
        .split_whitespace()
        .map(str::to_owned)
        .chain(typed)
        .collect();
    assert_eq!(names.len(), 75);
    for name in names {
        // SAFETY: the symbol is looked up, and not called.
        let found =
            unsafe { library.get::<unsafe extern "C" fn()>(format!("fmi3{name}").as_bytes()) };
        assert!(found.is_ok(), "fmi3{name}");
    }
}

#[test]
fn scenes_without_a_unit_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("refused.fmu");
    let file = folder.path().join("scene.toml");
    let library = library();
    let paths = [&file, &library, &out].map(|path| path.to_str().expect("UTF-8"));
    // The path of a file is found from everywhere, but its numbers are not in the unit.
    let table = folder.path().join("u.csv");
    let numbers: String = (0..9).map(|k| format!("{}\n", k * k)).collect();
    std::fs::write(&table, numbers).expect("a writable folder");
    let of_table = format!("tables = {{ U = {{ file = {table:?}, axes = {{ x = [-9, 9] }} }} }}");
    let in_a_table = BODY
        .replace("x3^2/(2*I3)", "x3^2/(2*I3) + U(x1)")
        .replace("[system]", &format!("[system]\n{of_table}"));
    for (scene, reason) in [
        (
            BODY.replace("x3^2/(2*I3)", "x3^2/(2*I3) + 0.1*x1*sin(t)"),
            "does not name the time",
        ),
        (
            BODY.replace("steps = 1000", "steps = 1000\nstop = \"x1 < 0\""),
            "a condition that stops it",
        ),
        (in_a_table, "this one reads"),
    ] {
        std::fs::write(&file, scene).expect("a writable folder");
        let (code, said) = program(&["fmu", paths[0], "--library", paths[1], "--out", paths[2]]);
        assert!(code == 2 && said.contains(reason), "{code} {said}");
        assert!(!out.exists());
    }
    std::fs::write(&file, BODY).expect("a writable folder");
    let missing = folder.path().join("libleafwise_missing.so");
    let missing = missing.to_str().expect("UTF-8");
    let (code, said) = program(&["fmu", paths[0], "--library", missing, "--out", paths[2]]);
    assert!(
        code != 0 && said.contains("libleafwise_missing"),
        "{code} {said}"
    );
    assert!(!out.exists());
}

/// FMPy, where it is installed, accepts the unit and gets the same bits.
#[test]
#[ignore = "needs python3 with FMPy"]
fn fmpy_simulates_a_unit() {
    let folder = tempfile::tempdir().expect("a folder");
    unit(folder.path(), BODY);
    let script = "import sys, struct, fmpy\nfrom fmpy.validation import validate_fmu\n\
        assert not (found := validate_fmu(sys.argv[1])), found\n\
        out = fmpy.simulate_fmu(sys.argv[1], stop_time=20.0, output_interval=0.2, fmi_type='CoSimulation')\n\
        names = ['x1', 'x2', 'x3', 'energy', 'spin']\n\
        [print(*(struct.unpack('Q', struct.pack('d', row[name]))[0] for name in names)) for row in out[1:]]";
    let ran = Command::new("python3")
        .args(["-c", script])
        .arg(folder.path().join("body.fmu"))
        .output();
    let ran = ran.expect("python3");
    let (out, err) = (
        String::from_utf8_lossy(&ran.stdout).into_owned(),
        String::from_utf8_lossy(&ran.stderr).into_owned(),
    );
    assert!(ran.status.success(), "{out}{err}");
    let expected = samples(BODY, 4, 100);
    assert_eq!(out.lines().count(), expected.len(), "{out}");
    for (line, expected) in out.lines().zip(expected) {
        let found = line
            .split_whitespace()
            .map(|word| word.parse().expect("bits"));
        let found: Vec<u64> = found.collect();
        assert_eq!(found, bits(&expected), "{line}");
    }
}
