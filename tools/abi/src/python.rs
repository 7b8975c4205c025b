//! The data classes of the SDK for Python.

use std::fmt::Write as _;

use crate::HEADER;
use crate::c_layout::used;
use crate::model::{Model, Record, Type, camel, snake, snake_if_name, with_names};

/// Returns the Python class of a record that has no generated class, and the expression that converts a received value.
fn special(name: &str) -> Option<(&'static str, &'static str)> {
    match name {
        "height-map" => Some(("Grid", "Grid._from_wire({}, \"<f4\")")),
        "label-map" => Some(("Grid", "Grid._from_wire({}, \"u1\")")),
        _ => None,
    }
}

/// Classes with manually written methods.
const WITH_METHODS: [&str; 4] = ["command", "lidar-info", "mount", "task"];

pub(crate) fn write(model: &Model) -> Result<String, String> {
    let mut out = format!(
        "\"\"\"Data classes of the planner interface. {HEADER}\"\"\"\n\nfrom dataclasses import dataclass, field\nfrom \
         typing import Dict, List, Optional\n\nimport numpy as np\n\nfrom ._methods import {}, Grid, number, \
         numbers, one_of\n",
        WITH_METHODS.map(|name| format!("{}Methods", camel(name))).join(", ")
    );
    for e in model.enums().filter(|e| e.name != "log-level") {
        let names = e.cases.iter().map(|(case, _)| format!("\"{case}\"")).collect::<Vec<_>>().join(", ");
        let _ = write!(out, "\n{}S = ({names})\n\"\"\"{}\"\"\"\n", snake(&e.name).to_uppercase(), e.docs);
    }
    for record in used(model, &["task", "observation", "command"])? {
        let is_param = ["param", "series", "grid-frame"].contains(&record.name.as_str());
        if !is_param && !model.is_vector(&record.name) && special(&record.name).is_none() {
            class(&mut out, model, record);
        }
    }
    Ok(out)
}

fn annotation(model: &Model, ty: &Type) -> String {
    match ty {
        Type::F64 | Type::F32 => "float".into(),
        Type::U8 | Type::U32 | Type::U64 => "int".into(),
        Type::Bool => "bool".into(),
        Type::Text | Type::Enum(_) => "str".into(),
        Type::Record(name) if model.is_vector(name) => "np.ndarray".into(),
        Type::Record(name) => special(name).map_or_else(|| camel(name), |(class, _)| class.into()),
        Type::Option(inner) => format!("Optional[{}]", annotation(model, inner)),
        Type::List(inner) => match &**inner {
            Type::Record(name) if name == "param" => "Dict[str, str]".into(),
            Type::Record(name) if name == "series" => "Dict[str, np.ndarray]".into(),
            Type::Record(name) if !model.is_vector(name) => format!("List[{}]", camel(name)),
            _ => "np.ndarray".into(),
        },
    }
}

/// Returns the expression that converts a received value.
fn read(model: &Model, ty: &Type, wire: &str) -> String {
    match ty {
        Type::Record(name) if model.is_vector(name) => format!("np.array({wire}, float)"),
        Type::Record(name) => match special(name) {
            Some((_, make)) => make.replace("{}", wire),
            None => format!("{}._from_wire({wire})", camel(name)),
        },
        Type::Option(inner) => format!("None if {wire} is None else {}", read(model, inner, wire)),
        Type::List(inner) => match &**inner {
            Type::F32 => format!("np.frombuffer({wire}, \"<f4\")"),
            Type::U8 => format!("np.frombuffer({wire}, \"u1\")"),
            Type::Record(name) if name == "param" => format!("{{p[\"key\"]: p[\"value\"] for p in {wire}}}"),
            Type::Record(name) if model.is_vector(name) => {
                let n = model.record(name).map_or(0, |r| r.fields.len());
                format!("np.array({wire}, float).reshape(-1, {n})")
            }
            Type::Record(name) => format!("[{}._from_wire(x) for x in {wire}]", camel(name)),
            _ => wire.into(),
        },
        _ => wire.into(),
    }
}

fn class(out: &mut String, model: &Model, r: &Record) {
    let name = camel(&r.name);
    let methods =
        if WITH_METHODS.contains(&r.name.as_str()) { format!("({name}Methods)") } else { String::new() };
    let _ = write!(out, "\n\n@dataclass\nclass {name}{methods}:\n    \"\"\"{}\"\"\"\n\n", docs(&r.docs));
    let command = r.name == "command";
    for f in &r.fields {
        let default = match &f.ty {
            _ if !command => String::new(),
            Type::Enum(e) => {
                let e = model.enums().find(|x| x.name == *e);
                e.map_or_else(String::new, |e| format!(" = \"{}\"", e.cases[0].0))
            }
            Type::List(_) => " = field(default_factory=dict)".into(),
            _ => " = 0.0".into(),
        };
        let text = f.docs.clone() + &components(model, &f.ty);
        let _ = write!(
            out,
            "    {}: {}{default}\n    \"\"\"{}\"\"\"\n",
            snake(&f.name),
            annotation(model, &f.ty),
            docs(&text)
        );
    }
    if command {
        out.push_str("\n    def _to_wire(self):\n        wire = {}\n");
        for f in &r.fields {
            let name = snake(&f.name);
            let line = match &f.ty {
                Type::Enum(e) => {
                    format!(
                        "wire[\"{name}\"] = one_of(\"{name}\", self.{name}, {}S)",
                        snake(e).to_uppercase()
                    )
                }
                Type::List(_) => format!(
                    "if self.{name}:\n            wire[\"{name}\"] = [{{\"name\": str(k), \"values\": numbers(k, v)}} for k, v in \
                     self.{name}.items()]"
                ),
                _ => format!("wire[\"{name}\"] = number(\"{name}\", self.{name})"),
            };
            let _ = writeln!(out, "        {line}");
        }
        out.push_str("        return wire\n");
        return;
    }
    out.push_str("\n    @classmethod\n    def _from_wire(cls, wire):\n        return cls(\n");
    for f in &r.fields {
        let name = snake(&f.name);
        let _ = writeln!(out, "            {name}={},", read(model, &f.ty, &format!("wire[\"{name}\"]")));
    }
    out.push_str("        )\n");
}

/// Returns the description of the components of an array that stands for a vector or for a list of vectors.
fn components(model: &Model, ty: &Type) -> String {
    let of = |name: &str| {
        let fields = model.record(name).map_or(&[][..], |r| &r.fields);
        fields.iter().map(|f| f.name.as_str()).collect::<Vec<_>>().join(", ")
    };
    match ty {
        Type::Record(name) if model.is_vector(name) => format!(" Array of {}.", of(name)),
        Type::List(inner) => match &**inner {
            Type::Record(name) if model.is_vector(name) => {
                format!(" Array with a row of {} per point.", of(name))
            }
            _ => String::new(),
        },
        _ => String::new(),
    }
}

fn docs(text: &str) -> String {
    with_names(text, |n| {
        if ["wheel-odometry", "local-map"].contains(&n) || n.contains('/') {
            n.into()
        } else {
            snake_if_name(n)
        }
    })
    .replace('`', "``")
    .replace('\n', "\n    ")
}
