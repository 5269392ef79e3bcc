//! The lists of JSON keys in `--help`, derived from the structs that are printed.

use schemars::{JsonSchema, generate::SchemaSettings};
use serde_json::{Map, Value};

/// Help text with every key of a printed struct and its meaning, one a line; keys of lists and objects are indented.
///
/// `name[]` is a list, `name{}` an object from names to values; `(optional)` keys are left out where they do not apply.
pub fn json_keys<T: JsonSchema>() -> String {
    json_keys_under::<T>("JSON keys")
}

/// Like [`json_keys`], below another heading.
pub fn json_keys_under<T: JsonSchema>(heading: &str) -> String {
    let schema = SchemaSettings::draft2020_12().for_serialize().into_generator().into_root_schema_for::<T>();
    let root = schema.to_value();
    let mut lines = format!("{heading}:\n");
    write_keys(&mut lines, &root, &root, 1);
    lines
}

/// Writes the keys of an object, and below each key those of its value.
fn write_keys(out: &mut String, root: &Value, object: &Value, depth: usize) {
    let Some(properties) = object["properties"].as_object() else { return };
    let required: Vec<&str> = object["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    for (name, value) in properties {
        let held = resolve_schema(root, value);
        let (mark, inner) = match held {
            v if v["additionalProperties"].is_object() => ("{}", resolve_schema(root, &v["additionalProperties"])),
            v if v["items"].is_object() => ("[]", resolve_schema(root, &v["items"])),
            v => ("", v),
        };
        let optional = if required.contains(&name.as_str()) { "" } else { " (optional)" };
        let text = description(value).or_else(|| description(held)).unwrap_or_default();
        *out += &format!("{:1$}{name}{mark}{optional}: {text}\n", "", 2 * depth);
        write_keys(out, root, inner, depth + 1);
    }
}

/// Schema behind a reference or an optional value.
fn resolve_schema<'a>(root: &'a Value, value: &'a Value) -> &'a Value {
    if let Some(name) = value["$ref"].as_str().and_then(|r| r.strip_prefix("#/$defs/")) {
        return resolve_schema(root, &root["$defs"][name]);
    }
    let some = |v: &&Value| v["type"] != "null";
    value["anyOf"].as_array().and_then(|all| all.iter().find(some)).map_or(value, |one| resolve_schema(root, one))
}

/// The first paragraph of a doc comment, on one line.
fn description(value: &Value) -> Option<String> {
    let object: &Map<String, Value> = value.as_object()?;
    let text = object.get("description")?.as_str()?;
    Some(text.split("\n\n").next()?.split_whitespace().collect::<Vec<_>>().join(" "))
}
