//! The data in C, for `vb_planner.h`.

use std::fmt::Write as _;

use crate::HEADER;
use crate::c_layout::used;
use crate::model::{Model, Record, Type, camel, snake, snake_if_name, with_names};

pub(crate) fn write(model: &Model) -> Result<String, String> {
    let mut out = String::new();
    for e in model.enums().filter(|e| e.name != "log-level") {
        comment(&mut out, "", &e.docs);
        out.push_str("enum {\n");
        for (i, (case, docs)) in e.cases.iter().enumerate() {
            comment(&mut out, "    ", docs);
            let name = format!("{}_{}", snake(&e.name), snake(case)).to_uppercase();
            let comma = if i + 1 < e.cases.len() { "," } else { "" };
            let _ = writeln!(out, "    VB_{name} = {i}{comma}");
        }
        out.push_str("};\n\n");
    }
    for record in used(model, &["task", "observation", "command"])? {
        structure(&mut out, record);
    }
    Ok(out)
}

/// For the test that compares both: every struct with its fields, as calls of a macro in a block.
pub(crate) fn fields(model: &Model) -> Result<String, String> {
    let mut out = format!("// {HEADER}\n{{\n");
    for record in used(model, &["task", "observation", "command"])? {
        let mut names = Vec::new();
        for f in &record.fields {
            names.push(snake(&f.name));
            if matches!(f.ty, Type::List(_)) {
                names.push(format!("{}_len", snake(&f.name)));
            }
        }
        let (c, rust) = (snake(&record.name), camel(&record.name));
        let _ = writeln!(out, "    same!(\"vb_{c}\", C{rust}: {});", names.join(", "));
    }
    out.push_str("}\n");
    Ok(out)
}

fn c(ty: &Type) -> String {
    match ty {
        Type::F64 => "double ".into(),
        Type::F32 => "float ".into(),
        Type::U8 | Type::Bool => "uint8_t ".into(),
        Type::U32 | Type::Enum(_) => "uint32_t ".into(),
        Type::U64 => "uint64_t ".into(),
        Type::Text => "const char *".into(),
        Type::Record(name) => format!("vb_{} ", snake(name)),
        Type::List(inner) | Type::Option(inner) => format!("const {}*", c(inner)),
    }
}

fn structure(out: &mut String, r: &Record) {
    comment(out, "", &r.docs);
    let _ = writeln!(out, "typedef struct vb_{} {{", snake(&r.name));
    for f in &r.fields {
        let mut docs = f.docs.clone();
        match &f.ty {
            Type::Option(_) => docs.push_str(" NULL where it is absent."),
            Type::Enum(name) => {
                let _ = write!(docs, " One of VB_{}_….", snake(name).to_uppercase());
            }
            _ => {}
        }
        comment(out, "    ", &docs);
        let _ = writeln!(out, "    {}{};", c(&f.ty), snake(&f.name));
        if matches!(f.ty, Type::List(_)) {
            let _ = writeln!(out, "    size_t {}_len;", snake(&f.name));
        }
    }
    let _ = write!(out, "}} vb_{};\n\n", snake(&r.name));
}

/// A comment, wrapped at 120 columns.
fn comment(out: &mut String, indent: &str, docs: &str) {
    let docs = with_names(docs, snake_if_name).replace('`', "");
    let mut line = format!("{indent}/*");
    for word in docs.split_whitespace() {
        if line.chars().count() + 1 + word.chars().count() > 116 {
            let _ = writeln!(out, "{line}");
            line = format!("{indent} *");
        }
        line.push(' ');
        line.push_str(word);
    }
    let _ = writeln!(out, "{line} */");
}
