//! The keys of scenes as a JSON Schema, for editors.

use leafwise_core::part::{ParameterDefault, ParameterInfo, PartInfo};
use leafwise_core::{PartKind, Registry};
use serde_json::{Map, Value, json};

use super::schema::ROOT;
use super::shape::{Default, Keys, Shape, word_of};

/// The JSON Schema (draft 2020-12) of a scene with the parts and systems of a registry. It accepts every scene that the
/// reader does, but for spaces within words; what formulas say, and how many numbers a vector has, it does not know. Parts
/// of plugins, with a `/` in their names, may have any parameters where they are not in the registry.
pub fn json_schema(registry: &Registry) -> Value {
    let mut schema = of_shape(&ROOT, registry);
    let about = [
        ("$schema", "https://json-schema.org/draft/2020-12/schema"),
        ("title", "A scene of Leafwise"),
    ];
    for (key, value) in about {
        schema[key] = value.into();
    }
    schema
}

fn of_table(table: &Keys, registry: &Registry) -> Value {
    let mut properties = Map::new();
    for key in table.keys {
        let mut own = of_shape(&key.shape, registry);
        own["description"] = key.about.into();
        if let Some(Default::Toml(written)) = key.default {
            own["default"] = json_of(written);
        }
        properties.insert(key.name.to_owned(), own);
    }
    let mut schema = json!({
        "type": "object",
        "properties": properties,
        "additionalProperties": false,
    });
    match table.needs {
        [] => {}
        [needed] => schema["required"] = json!(needed),
        sets => {
            let each = sets.iter().map(|needed| json!({ "required": needed }));
            schema["anyOf"] = each.collect();
        }
    }
    schema
}

/// A value that is written as TOML.
fn json_of(written: &str) -> Value {
    let table = toml::from_str(&format!("value = {written}"));
    let value = table.map(|mut table: Map<String, Value>| table.remove("value"));
    value.ok().flatten().unwrap_or_default()
}

fn of_shape(shape: &Shape, registry: &Registry) -> Value {
    let nested = |shape: &Shape| of_shape(shape, registry);
    match shape {
        Shape::Text => json!({ "type": "string" }),
        Shape::Formula => json!({ "type": ["string", "number"] }),
        Shape::Number => json!({ "type": "number" }),
        Shape::Whole(least) => json!({ "type": "integer", "minimum": least }),
        Shape::Anything => json!({}),
        Shape::Words(words) => json!({ "enum": words }),
        Shape::List(entry) => json!({ "type": "array", "items": nested(entry) }),
        Shape::Entries(entries) => {
            let each: Vec<Value> = entries.iter().map(nested).collect();
            let count = each.len();
            json!({ "type": "array", "prefixItems": each, "minItems": count, "maxItems": count })
        }
        Shape::Table(table) => of_table(table, registry),
        Shape::Names(each) => json!({ "type": "object", "additionalProperties": nested(each) }),
        Shape::Pairs(each) => json!({
            "type": "object",
            "patternProperties": { "^[^,]+,[^,]+$": nested(each) },
            "additionalProperties": false,
        }),
        Shape::Either(shapes) => {
            let each: Vec<Value> = shapes.iter().map(nested).collect();
            json!({ "anyOf": each })
        }
        Shape::Part(kind) => of_parts(*kind, registry),
        Shape::System => {
            let systems = infos(PartKind::System, registry);
            let mut each: Vec<Value> = systems.map(named).collect();
            each.push(foreign());
            json!({ "anyOf": each })
        }
    }
}

fn infos(kind: PartKind, registry: &Registry) -> impl Iterator<Item = &'static PartInfo> {
    let parts = registry.listing().into_iter().map(|(info, _)| info);
    parts.filter(move |info| info.kind == kind)
}

/// A part's name with what it is.
fn named(info: &'static PartInfo) -> Value {
    json!({ "const": info.name, "description": info.summary })
}

/// A name of a part of a plugin.
fn foreign() -> Value {
    json!({ "type": "string", "pattern": "^[^/]+/[^/]+$" })
}

fn of_parts(kind: PartKind, registry: &Registry) -> Value {
    let about = match kind {
        PartKind::Composition => "steps as they are",
        _ => "the part that fits best",
    };
    let word = json!({ "const": word_of(kind), "description": about });
    let mut each: Vec<Value> = infos(kind, registry).map(named).collect();
    each.extend([word.clone(), foreign()]);
    for info in infos(kind, registry) {
        let mut properties = Map::from_iter([("name".to_owned(), named(info))]);
        let parameters = info
            .parameters
            .iter()
            .map(|one| (one.name.to_owned(), of_parameter(one)));
        properties.extend(parameters);
        each.push(json!({
            "type": "object",
            "properties": properties,
            "required": ["name"],
            "additionalProperties": false,
        }));
    }
    for name in [word, foreign()] {
        each.push(
            json!({ "type": "object", "properties": { "name": name }, "required": ["name"] }),
        );
    }
    json!({ "anyOf": each })
}

fn of_parameter(parameter: &ParameterInfo) -> Value {
    let shape = match parameter.default {
        ParameterDefault::Formulas(_) => {
            let formula = json!({ "type": ["string", "number"] });
            return json!({
                "anyOf": [formula, { "type": "array", "items": formula }],
                "description": parameter.summary,
                "default": parameter.default,
            });
        }
        ParameterDefault::Integer(_) => "integer",
        ParameterDefault::Real(_) => "number",
        ParameterDefault::Text(_) => "string",
    };
    json!({ "type": shape, "description": parameter.summary, "default": parameter.default })
}

#[cfg(test)]
mod tests {
    use super::super::schema::each_key;
    use super::*;

    #[test]
    fn every_default_is_toml() {
        for (path, key) in each_key() {
            if let Some(Default::Toml(written)) = key.default {
                assert_ne!(json_of(written), Value::Null, "{path}");
            }
        }
    }
}
