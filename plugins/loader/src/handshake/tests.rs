//! Declarations that contradict themselves or the interface.

use std::ffi::CString;

use leafwise_plugin_abi::{
    LW_FLAG_COTANGENT_CHART, LW_FLAG_NOT_SELF_ADJOINT, LW_FLAG_REVERSIBLE, LW_FLAG_SELF_ADJOINT,
    LW_KIND_DYNAMICS, LW_KIND_REALIZATION, LW_KIND_STEP_MAP, LwEntry, LwExpression, LwParameter,
    LwPart,
};

use super::*;
use crate::declaration::ValuePath;

/// An entry with one part by formulas, changed by `change`.
fn read_with(change: impl FnOnce(&mut LwEntry, &mut LwPart)) -> Result<PluginDeclaration, String> {
    let formula = LwExpression {
        key: c"alpha.1".as_ptr(),
        formula: c"x1 - c*epsilon*p1".as_ptr(),
    };
    let parameter = LwParameter {
        name: c"c".as_ptr(),
        summary: c"a factor".as_ptr(),
        default_json: c"0.5".as_ptr(),
    };
    let mut part = LwPart {
        kind: LW_KIND_REALIZATION,
        id: c"acme/chart".as_ptr(),
        summary: c"a chart".as_ptr(),
        parameters: &raw const parameter,
        parameter_count: 1,
        expressions: &raw const formula,
        expression_count: 1,
        order: 1,
        flags: LW_FLAG_COTANGENT_CHART,
        ..LwPart::empty()
    };
    let mut entry = LwEntry {
        magic: LW_MAGIC,
        abi_major: LW_ABI_MAJOR,
        real_bytes: 8,
        part_count: 1,
        id: c"acme".as_ptr(),
        version: c"1.2.3".as_ptr(),
        ..LwEntry::empty()
    };
    change(&mut entry, &mut part);
    let parts = [&raw const part];
    if entry.parts.is_null() {
        entry.parts = parts.as_ptr();
    }
    // SAFETY: everything the entry leads to lives here.
    unsafe { read(&raw const entry) }.map_err(|refusal| refusal.to_string())
}

#[test]
fn what_is_declared_is_copied() {
    let plugin = read_with(|_, _| {}).expect("a good entry");
    assert_eq!(
        (plugin.id.as_str(), plugin.version.as_str()),
        ("acme", "1.2.3")
    );
    assert_eq!((plugin.license, plugin.abi.as_str()), (None, "1.0"));
    let part = &plugin.parts[0];
    assert_eq!(part.id(), "acme/chart");
    assert_eq!(part.paths(), [ValuePath::Expressions]);
    assert_eq!(
        part.formulas,
        [("alpha.1".to_owned(), "x1 - c*epsilon*p1".to_owned())]
    );
    assert_eq!(part.description.parameters[0].default, 0.5.into());
}

#[test]
fn an_id_is_vendor_and_name() {
    for (id, text) in [
        (c"chart", "part id `chart`: an id is `acme/name`"),
        (c"acme/a/b", "an id is `acme/name`"),
        (c"acme/Chart", "an id is `acme/name`"),
        (c"acme/", "an id is `acme/name`"),
        (c"other/chart", "it begins with the plugin's id, `acme/`"),
    ] {
        let error = read_with(|_, part| part.id = id.as_ptr()).expect_err("no id");
        assert!(error.contains(text), "{id:?}: {error}");
    }
    let error = read_with(|entry, _| entry.id = c"Acme Inc".as_ptr()).expect_err("no word");
    assert!(
        error.contains("`Acme Inc` is not a word of lower-case letters"),
        "{error}"
    );
}

#[test]
fn contradictions_are_named() {
    type Change = fn(&mut LwEntry, &mut LwPart);
    let cases: [(Change, &str); 15] = [
        (
            |e, _| e.real_bytes = 4,
            "its real numbers have 4 bytes, the host's 8",
        ),
        (
            |e, _| e.struct_size = 20,
            "LwEntry: struct_size 20 is impossible",
        ),
        (
            |e, _| e.part_count = 5000,
            "the list of parts: 5000 entries are more than 4096",
        ),
        (
            |e, _| e.version = std::ptr::null(),
            "the plugin's version is NULL",
        ),
        (|_, p| p.kind = 9, "part acme/chart: kind 9 is unknown"),
        (
            |_, p| p.expression_count = 0,
            "it has neither functions nor expressions",
        ),
        (
            |_, p| p.expressions = std::ptr::null(),
            "expressions: NULL in place of 1 entries",
        ),
        (|_, p| p.order = 0, "order 0 is less than 1"),
        (
            |_, p| p.parameter_count = usize::MAX,
            "entries are more than 4096",
        ),
        (
            |_, p| (p.dim_min, p.dim_max) = (4, 3),
            "dim_max is less than dim_min",
        ),
        (
            |_, p| p.flags = LW_FLAG_REVERSIBLE,
            "needs LW_FLAG_COTANGENT_CHART",
        ),
        (
            |_, p| p.flags = 0,
            "formulas of a realization need LW_FLAG_COTANGENT_CHART",
        ),
        (
            |_, p| {
                p.kind = LW_KIND_STEP_MAP;
                p.flags = LW_FLAG_SELF_ADJOINT | LW_FLAG_NOT_SELF_ADJOINT;
            },
            "it is declared self-adjoint and not self-adjoint",
        ),
        (
            |_, p| (p.kind, p.structure) = (LW_KIND_STEP_MAP, -2),
            "structure -2 is unknown",
        ),
        (
            |_, p| p.summary = c" ".as_ptr(),
            "part acme/chart: summary is empty",
        ),
    ];
    for (change, text) in cases {
        let error = read_with(change).expect_err("a contradiction");
        assert!(error.contains(text), "`{text}` is missing from: {error}");
    }
}

#[test]
fn a_dynamic_approximation_has_one_map() {
    let mut table = leafwise_plugin_abi::LwDynamics::empty();
    table.life.create = Some(create);
    table.life.destroy = Some(destroy);
    let with = |table: &leafwise_plugin_abi::LwDynamics| {
        read_with(|_, part| {
            part.kind = LW_KIND_DYNAMICS;
            part.expression_count = 0;
            part.functions = (&raw const *table).cast();
        })
    };
    let error = with(&table).expect_err("no map");
    assert!(
        error.contains("required function `one_form, embedding or flow` is NULL"),
        "{error}"
    );
    table.flow = Some(map);
    assert!(with(&table).is_ok());
    table.embedding = Some(map);
    let error = with(&table).expect_err("two maps");
    assert!(
        error.contains("exactly one of one_form, embedding and flow"),
        "{error}"
    );
}

unsafe extern "C" fn create(
    _: *const leafwise_plugin_abi::LwCreate,
    _: *mut *mut std::ffi::c_void,
    _: *mut leafwise_plugin_abi::LwError,
) -> i32 {
    0
}

unsafe extern "C" fn destroy(_: *mut std::ffi::c_void) {}

unsafe extern "C" fn map(
    _: *mut std::ffi::c_void,
    _: *const leafwise_plugin_abi::LwMapCall,
    _: *mut leafwise_plugin_abi::LwError,
) -> i32 {
    0
}

#[test]
fn parameters_have_names_types_and_no_twins() {
    let with = |parameters: &[(&str, &str)]| {
        let texts: Vec<[CString; 2]> = parameters
            .iter()
            .map(|(name, json)| [name, json].map(|text| CString::new(*text).expect("no NUL")))
            .collect();
        let list: Vec<LwParameter> = texts
            .iter()
            .map(|[name, json]| LwParameter {
                name: name.as_ptr(),
                summary: c"a number".as_ptr(),
                default_json: json.as_ptr(),
            })
            .collect();
        read_with(|_, part| {
            part.parameters = list.as_ptr();
            part.parameter_count = list.len();
        })
        .map(drop)
    };
    assert_eq!(
        with(&[("c", "0.5"), ("n_2", "3"), ("word", "\"none\"")]),
        Ok(())
    );
    for (parameters, text) in [
        (
            &[("2c", "1")][..],
            "parameter `2c` is not a letter followed by",
        ),
        (&[("c", "1"), ("c", "2")], "parameter `c` is declared twice"),
        (
            &[("path", "1")],
            "parameter `path` has a name that the host reserves",
        ),
        (
            &[("name", "1")],
            "parameter `name` has a name that the host reserves",
        ),
        (
            &[("c", "true")],
            "has the default true, which is neither a finite number nor",
        ),
    ] {
        let error = with(parameters).expect_err("a wrong parameter");
        assert!(error.contains(text), "`{text}` is missing from: {error}");
    }
}
