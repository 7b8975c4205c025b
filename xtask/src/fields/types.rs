//! The types of a format's sources, and the sections of a page on them.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use syn::{
    Attribute, Expr, Fields, GenericArgument, Item, ItemEnum, ItemStruct, Lit, Meta, PathArguments, Type,
};

use super::{Format, macros};
use crate::run::Failure;

/// The list of tyre models, a macro, and the enum that it makes.
const TYRES: [&str; 2] = ["tyre/mod.rs", "TyreSpec"];

/// The types of a format's sources, by name.
pub(super) struct Types<'a> {
    format: &'a Format,
    structs: BTreeMap<String, ItemStruct>,
    enums: BTreeMap<String, ItemEnum>,
    /// Constants; functions without arguments and `Default::default` of types: the expressions that they return.
    values: BTreeMap<String, Expr>,
    /// Name, variant's data and comment of each tyre model.
    tyres: Vec<[String; 3]>,
}

impl<'a> Types<'a> {
    pub(super) fn read(root: &Path, format: &'a Format) -> Result<Self, Failure> {
        let mut types = Self {
            format,
            structs: BTreeMap::new(),
            enums: BTreeMap::new(),
            values: BTreeMap::new(),
            tyres: Vec::new(),
        };
        let mut places: Vec<_> = format.sources.iter().rev().map(|source| root.join(source)).collect();
        while let Some(place) = places.pop() {
            let failed = |e: std::io::Error| Failure::new(format!("can't read {}: {e}", place.display()));
            if place.is_dir() {
                for entry in std::fs::read_dir(&place).map_err(failed)? {
                    places.push(entry.map_err(failed)?.path());
                }
            } else if place.extension().is_some_and(|e| e == "rs") {
                let text = std::fs::read_to_string(&place).map_err(failed)?;
                if place.ends_with(TYRES[0]) {
                    types.tyres = tyres(&text);
                }
                let file =
                    syn::parse_file(&text).map_err(|e| Failure::new(format!("{}: {e}", place.display())))?;
                types.take_all(file.items);
            }
        }
        Ok(types)
    }

    /// Takes what a file declares, also by macros that are made of lists.
    fn take_all(&mut self, items: Vec<Item>) {
        let enums: BTreeMap<String, ItemEnum> = items
            .iter()
            .filter_map(|item| if let Item::Macro(m) = item { macros::enum_of(m) } else { None })
            .collect();
        for item in items {
            match item {
                Item::Macro(m) if m.ident.is_none() => {
                    let called = m.mac.path.segments.last().map(|s| s.ident.to_string()).unwrap_or_default();
                    if let Some(of) = enums.get(&called)
                        && let Ok(macros::Variants(variants)) = m.mac.parse_body()
                    {
                        let mut made = of.clone();
                        made.variants.extend(variants);
                        self.enums.entry(made.ident.to_string()).or_insert(made);
                    } else if let Ok(macros::Measures(made)) = m.mac.parse_body() {
                        self.structs.entry(made.ident.to_string()).or_insert(made);
                    }
                }
                item => self.take(item),
            }
        }
    }

    fn take(&mut self, item: Item) {
        let returned = |block: &syn::Block| match block.stmts.as_slice() {
            [syn::Stmt::Expr(value, None)] => Some(value.clone()),
            _ => None,
        };
        match item {
            Item::Struct(s) if is_read(&s.attrs) => {
                self.structs.entry(s.ident.to_string()).or_insert(s);
            }
            Item::Enum(e) if is_read(&e.attrs) => {
                self.enums.entry(e.ident.to_string()).or_insert(e);
            }
            Item::Const(c) => {
                self.values.entry(c.ident.to_string()).or_insert(*c.expr);
            }
            Item::Fn(f) if f.sig.inputs.is_empty() => {
                if let Some(value) = returned(&f.block) {
                    self.values.insert(f.sig.ident.to_string(), value);
                }
            }
            Item::Impl(i) => {
                let default = i.items.iter().find_map(|item| match item {
                    syn::ImplItem::Fn(f) if f.sig.ident == "default" => returned(&f.block),
                    _ => None,
                });
                if let (Some(value), Type::Path(of)) = (default, &*i.self_ty)
                    && let Some(of) = of.path.get_ident()
                {
                    self.values.insert(of.to_string(), value);
                }
            }
            _ => {}
        }
    }

    /// A section for each type that a file can hold, in the order in which a reader meets them.
    pub(super) fn sections(&self) -> Result<String, Failure> {
        let mut out = String::new();
        if !self.format.title.is_empty() {
            let _ = write!(out, "## {}\n\n{}\n\n", self.format.title, self.format.about);
        }
        let mut order = vec![self.format.root.to_owned()];
        let mut next = 0;
        while let Some(name) = order.get(next).cloned() {
            next += 1;
            let (text, named) = self.section(&name)?;
            out.push_str(&text);
            for other in named {
                if !order.contains(&other) {
                    order.push(other);
                }
            }
        }
        Ok(out)
    }

    /// The heading of a type; none for the whole file on a page of several formats, whose title it has.
    fn heading(&self, name: &str) -> String {
        match self.format.title {
            "" => format!("## {}\n\n", title(name)),
            _ if name == self.format.root => String::new(),
            of => format!("### {of}: {}\n\n", title(name).to_lowercase()),
        }
    }

    /// A link to the section of a type.
    fn link(&self, name: &str) -> String {
        let text = title(name).to_lowercase();
        let own = match self.format.title {
            "" => text.clone(),
            of => format!("{}: {text}", of.to_lowercase()),
        };
        format!("[{text}](#{})", anchor(&own))
    }

    /// The section of a type, and the types that it names.
    fn section(&self, name: &str) -> Result<(String, Vec<String>), Failure> {
        let mut named = Vec::new();
        let mut out = self.heading(name);
        if name == TYRES[1] {
            out.push_str("The first field, `model`, selects the model; its own fields follow.\n\n| `model` | meaning | fields |\n|---|---|---|\n");
            for [model, data, comment] in &self.tyres {
                let _ = writeln!(out, "| `{model}` | {comment} | {} |", self.link(data));
                named.push(data.clone());
            }
            out.push('\n');
        } else if let Some(s) = self.structs.get(name) {
            let about = comment(&s.attrs);
            if !about.is_empty() {
                let _ = write!(out, "{about}\n\n");
            }
            out.push_str("| field | type | if absent | meaning |\n|---|---|---|---|\n");
            self.rows(&mut out, "", &s.fields, &mut named)?;
            out.push('\n');
        } else if let Some(e) = self.enums.get(name) {
            let _ = write!(out, "{}\n\n", comment(&e.attrs));
            self.variants(&mut out, e, &mut named)?;
        }
        Ok((out, named))
    }

    /// Whether the sources have a type.
    fn has(&self, name: &str) -> bool {
        self.structs.contains_key(name)
            || self.enums.contains_key(name)
            || (name == TYRES[1] && !self.tyres.is_empty())
    }

    /// A row for each field.
    fn rows(
        &self,
        out: &mut String,
        before: &str,
        fields: &Fields,
        named: &mut Vec<String>,
    ) -> Result<(), Failure> {
        for field in fields.iter().filter(|field| serde(&field.attrs, "skip").is_none()) {
            let name = field.ident.as_ref().map(ToString::to_string).unwrap_or_default();
            let name = serde(&field.attrs, "rename").unwrap_or(name);
            let optional = matches!(&field.ty, Type::Path(path) if last(path) == "Option");
            let absent = match serde(&field.attrs, "default") {
                // What reads a file takes such a field as not given.
                None if optional => "none".to_owned(),
                None => "required".to_owned(),
                Some(function) if function.is_empty() => self.default_of(&field.ty),
                Some(function) => match self.values.get(&function) {
                    Some(value) => shown(value, &self.values),
                    None => {
                        return Err(Failure::new(format!("{} has no function {function}", self.format.root)));
                    }
                },
            };
            if serde(&field.attrs, "flatten").is_some() {
                let _ = writeln!(out, "| … | fields | required | {} |", comment(&field.attrs));
                continue;
            }
            let kind = self.kind(&field.ty, named)?;
            let meaning = self.meaning(&name, field)?;
            let _ = writeln!(out, "| {before}`{name}` | {kind} | {absent} | {meaning} |");
        }
        Ok(())
    }

    /// The description of a field: its comment, or that of its type.
    fn meaning(&self, name: &str, field: &syn::Field) -> Result<String, Failure> {
        let own = comment(&field.attrs);
        if !own.is_empty() {
            return Ok(own);
        }
        let of_type = match &field.ty {
            Type::Path(path) => {
                let inner = inner(path).unwrap_or_else(|| last(path));
                let attributes = self.structs.get(&inner).map(|s| &s.attrs);
                attributes.or_else(|| self.enums.get(&inner).map(|e| &e.attrs)).map(|a| comment(a))
            }
            _ => None,
        };
        match (of_type, name) {
            (Some(about), _) if !about.is_empty() => {
                Ok(about.split_once(". ").map_or(about.clone(), |(first, _)| format!("{first}.")))
            }
            (_, "schema") => Ok("Version of the format.".to_owned()),
            (_, "name") => Ok("The name.".to_owned()),
            (_, "description") => Ok("A description in one line, for people.".to_owned()),
            _ if self.format.title.is_empty() => Ok("joint of the linkage".to_owned()),
            _ => {
                let what = format!("{}: the field {name} has no comment", self.format.title);
                Err(Failure::new(format!("{what}, which the reference of fields needs")))
            }
        }
    }

    fn variants(&self, out: &mut String, e: &ItemEnum, named: &mut Vec<String>) -> Result<(), Failure> {
        let value = |v: &syn::Variant| written(e, v);
        let usual = |v: &syn::Variant| {
            if v.attrs.iter().any(|a| a.path().is_ident("default")) { " (if absent)" } else { "" }
        };
        let tag = serde(&e.attrs, "tag");
        if tag.is_none() && e.variants.iter().all(|v| v.fields.is_empty()) {
            out.push_str("| value | meaning |\n|---|---|\n");
            for v in &e.variants {
                let _ = writeln!(out, "| `{}`{} | {} |", value(v), usual(v), comment(&v.attrs));
            }
            out.push('\n');
            return Ok(());
        }
        // Without a tag, the variant is the key of its fields, and a text if it has none.
        let tag = tag.map_or_else(|| "key".to_owned(), |tag| format!("`{tag}`"));
        let _ = write!(out, "| {tag} | meaning | fields |\n|---|---|---|\n");
        for v in &e.variants {
            let fields = match &v.fields {
                Fields::Unnamed(data) => {
                    let data = data.unnamed.first().map(|f| self.kind(&f.ty, named)).transpose()?;
                    data.unwrap_or_default()
                }
                fields if fields.is_empty() => "none".to_owned(),
                fields => {
                    let names =
                        fields.iter().filter_map(|f| f.ident.as_ref()).map(|name| format!("`{name}`"));
                    names.collect::<Vec<_>>().join(", ")
                }
            };
            let _ = writeln!(out, "| `{}`{} | {} | {fields} |", value(v), usual(v), comment(&v.attrs));
        }
        if e.variants.iter().any(|v| matches!(v.fields, Fields::Named(_)) && !v.fields.is_empty()) {
            let _ = write!(out, "\n| {tag} | field | type | if absent | meaning |\n|---|---|---|---|---|\n");
            for v in e.variants.iter().filter(|v| matches!(v.fields, Fields::Named(_))) {
                self.rows(out, &format!("`{}` | ", value(v)), &v.fields, named)?;
            }
        }
        out.push('\n');
        Ok(())
    }

    /// A type as people read it.
    fn kind(&self, ty: &Type, named: &mut Vec<String>) -> Result<String, Failure> {
        let unknown = || {
            Failure::new(format!(
                "{}: no words for a type of a field; add them to xtask/src/fields.rs",
                self.format.root
            ))
        };
        match ty {
            Type::Array(array) => {
                let Expr::Lit(syn::ExprLit { lit: Lit::Int(count), .. }) = &array.len else {
                    return Err(unknown());
                };
                let count: usize = count.base10_parse().map_err(|_| unknown())?;
                let inner = self.kind(&array.elem, named)?;
                Ok(if inner == "number" {
                    format!("[{}]", vec!["number"; count].join(", "))
                } else {
                    format!("{count} of {inner}")
                })
            }
            Type::Path(path) => {
                let name = last(path);
                let last = path.path.segments.last().ok_or_else(unknown)?;
                let mut inner = Vec::new();
                if let PathArguments::AngleBracketed(arguments) = &last.arguments {
                    for argument in &arguments.args {
                        if let GenericArgument::Type(ty) = argument {
                            inner.push(self.kind(ty, named)?);
                        }
                    }
                }
                Ok(match (name.as_str(), inner.as_slice()) {
                    ("f64" | "f32", _) => "number".to_owned(),
                    ("u8" | "u16" | "u32" | "u64" | "usize" | "i32" | "i64", _) => "whole number".to_owned(),
                    ("String" | "PathBuf" | "TaskId", _) => "text".to_owned(),
                    ("char", _) => "letter".to_owned(),
                    ("FaultCode", _) => "[code](abi.md#faults)".to_owned(),
                    ("Value", _) => "any".to_owned(),
                    // Of a type with a parameter.
                    ("T", _) => "value".to_owned(),
                    ("bool", _) => "`true` or `false`".to_owned(),
                    ("Point", _) => "[x, y, z]".to_owned(),
                    ("Schema", _) => "1".to_owned(),
                    ("Option" | "Arc" | "Box", [inner]) => inner.clone(),
                    ("Vec" | "BTreeSet", [inner]) => format!("list of {inner}"),
                    ("BTreeMap", [_, inner]) => format!("map from names to {inner}"),
                    // An untagged enum has no section; its comment describes it.
                    _ if self.enums.get(&name).is_some_and(|e| serde(&e.attrs, "untagged").is_some()) => {
                        let text = comment(&self.enums[&name].attrs);
                        let mut letters = text.trim_end_matches('.').chars();
                        let first = letters.next().map(|c| c.to_lowercase().to_string()).unwrap_or_default();
                        format!("{first}{}", letters.as_str())
                    }
                    _ if self.format.root != name && super::titled(&name).is_some() => {
                        let title = super::titled(&name).unwrap_or_default();
                        format!("[{title}](#{})", anchor(title))
                    }
                    _ if self.has(&name) => {
                        named.push(name.clone());
                        self.link(&name)
                    }
                    _ => {
                        let what = format!("{}: the sources have no type {name}", self.format.root);
                        return Err(Failure::new(what));
                    }
                })
            }
            _ => Err(unknown()),
        }
    }

    /// What a field is that may be left out.
    fn default_of(&self, ty: &Type) -> String {
        let Type::Path(path) = ty else { return "zeros".to_owned() };
        let name = last(path);
        match name.as_str() {
            "f64" => "0".to_owned(),
            "bool" => "`false`".to_owned(),
            "String" => "empty".to_owned(),
            "Option" => "none".to_owned(),
            "Vec" | "BTreeMap" => "empty".to_owned(),
            "u32" | "u64" | "usize" => "0".to_owned(),
            name => {
                let usual = self.enums.get(name).and_then(|e| {
                    let usual =
                        e.variants.iter().find(|v| v.attrs.iter().any(|a| a.path().is_ident("default")));
                    usual.map(|v| written(e, v))
                });
                match (usual, self.values.get(name)) {
                    (Some(value), _) => format!("`{value}`"),
                    (None, Some(value)) => shown(value, &self.values),
                    (None, None) => "its defaults".to_owned(),
                }
            }
        }
    }
}

/// A variant as files write it.
fn written(e: &ItemEnum, v: &syn::Variant) -> String {
    serde(&v.attrs, "rename").unwrap_or_else(|| {
        let name = v.ident.to_string();
        match serde(&e.attrs, "rename_all").unwrap_or_default().as_str() {
            "lowercase" => name.to_lowercase(),
            "kebab-case" => snake(&name).replace('_', "-"),
            _ => snake(&name),
        }
    })
}

/// The anchor of a heading.
fn anchor(heading: &str) -> String {
    let kept = |c: &char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_');
    heading.to_lowercase().chars().filter(kept).collect::<String>().replace(' ', "-")
}

/// Whether files are read into a type.
fn is_read(attributes: &[Attribute]) -> bool {
    let derives = attributes.iter().filter(|a| a.path().is_ident("derive"));
    derives
        .filter_map(|a| a.meta.require_list().ok())
        .any(|list| list.tokens.to_string().contains("Deserialize"))
}

/// The name of the type in an option or a list.
fn inner(path: &syn::TypePath) -> Option<String> {
    let PathArguments::AngleBracketed(arguments) = &path.path.segments.last()?.arguments else { return None };
    arguments.args.iter().find_map(|argument| match argument {
        GenericArgument::Type(Type::Path(path)) => Some(last(path)),
        _ => None,
    })
}

/// The name of a type without modules.
fn last(path: &syn::TypePath) -> String {
    path.path.segments.last().map(|s| s.ident.to_string()).unwrap_or_default()
}

/// The rows of the list of tyre models: name, data and comment.
fn tyres(text: &str) -> Vec<[String; 3]> {
    let rows = text.split("$with! {").nth(1).and_then(|rest| rest.split('}').next()).unwrap_or_default();
    let mut said = Vec::new();
    let mut found = Vec::new();
    for line in rows.lines().map(str::trim) {
        if let Some(comment) = line.strip_prefix("///") {
            said.push(comment.trim().to_owned());
        } else if let [model, _, data] = line.trim_end_matches(',').split_whitespace().collect::<Vec<_>>()[..]
        {
            found.push([model.to_owned(), data.to_owned(), std::mem::take(&mut said).join(" ")]);
        }
    }
    found
}

/// The value of an argument of `serde`; empty for one without a value.
fn serde(attributes: &[Attribute], wanted: &str) -> Option<String> {
    let mut found = None;
    for attribute in attributes.iter().filter(|a| a.path().is_ident("serde")) {
        // What follows arguments that are of no interest here is skipped with them.
        let _ = attribute.parse_nested_meta(|meta| {
            let value = meta.value().and_then(|value| value.parse::<Lit>()).ok();
            if meta.path.is_ident(wanted) {
                found = Some(match value {
                    Some(Lit::Str(text)) => text.value(),
                    _ => String::new(),
                });
            }
            Ok(())
        });
    }
    found
}

/// The comment of an item in one line.
fn comment(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|a| match &a.meta {
        Meta::NameValue(n) if n.path.is_ident("doc") => match &n.value {
            Expr::Lit(syn::ExprLit { lit: Lit::Str(text), .. }) => Some(text.value().trim().to_owned()),
            _ => None,
        },
        _ => None,
    });
    let text = lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
    plain(&text)
}

/// A comment without links to code, for a cell of a table.
fn plain(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, after)) = rest.split_once("[`") {
        out.push_str(before);
        let Some((name, after)) = after.split_once("`]") else { break };
        let _ = write!(out, "`{}`", name.rsplit("::").next().unwrap_or(name));
        rest = match after.strip_prefix('(').and_then(|link| link.split_once(')')) {
            Some((_, after)) => after,
            None => after,
        };
    }
    out.push_str(rest);
    out.replace("\\[", "[").replace("\\]", "]").replace('|', "\\|")
}

/// An expression as a value of a file, with the values of these constants.
fn shown(value: &Expr, constants: &BTreeMap<String, Expr>) -> String {
    let inner = |value: &Expr| shown(value, constants);
    let number = |text: String| text.strip_suffix(".0").map_or(text.clone(), str::to_owned);
    match value {
        Expr::Lit(syn::ExprLit { lit: Lit::Float(f), .. }) => number(f.base10_digits().to_owned()),
        Expr::Lit(syn::ExprLit { lit: Lit::Int(n), .. }) => n.base10_digits().to_owned(),
        Expr::Lit(syn::ExprLit { lit: Lit::Str(text), .. }) => format!("`{}`", text.value()),
        Expr::Path(path) if path.path.segments.last().is_some_and(|s| s.ident == "INFINITY") => {
            "∞".to_owned()
        }
        Expr::Path(path) if path.path.segments.last().is_some_and(|s| s.ident == "NEG_INFINITY") => {
            "−∞".to_owned()
        }
        Expr::Path(path) => {
            let constant = path.path.segments.last().and_then(|s| constants.get(&s.ident.to_string()));
            constant.map_or_else(|| "its default".to_owned(), inner)
        }
        // `"text".to_owned()`, `"text".into()`.
        Expr::MethodCall(call) => inner(&call.receiver),
        Expr::Macro(list) if list.mac.path.is_ident("vec") => {
            let values = list
                .mac
                .parse_body_with(syn::punctuated::Punctuated::<Expr, syn::Token![,]>::parse_terminated);
            let values = values.map(|v| v.iter().map(inner).collect::<Vec<_>>().join(", "));
            values.map_or_else(|_| "its default".to_owned(), |v| format!("[{v}]"))
        }
        Expr::Array(array) => format!("[{}]", array.elems.iter().map(inner).collect::<Vec<_>>().join(", ")),
        Expr::Struct(s) => {
            let field = |f: &syn::FieldValue| match &f.member {
                syn::Member::Named(name) => format!("`{name}: {}`", inner(&f.expr)),
                syn::Member::Unnamed(_) => inner(&f.expr),
            };
            s.fields.iter().map(field).collect::<Vec<_>>().join(", ")
        }
        _ => "its default".to_owned(),
    }
}

/// A type's name in words: `DoubleWishbone` is "Double wishbone".
fn title(name: &str) -> String {
    let words = snake(name.strip_suffix("Spec").unwrap_or(name)).replace('_', " ");
    let mut letters = words.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
}

fn snake(name: &str) -> String {
    let mut out = String::new();
    for c in name.chars() {
        if c.is_uppercase() && !out.is_empty() {
            out.push('_');
        }
        out.extend(c.to_lowercase());
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_lose_their_links_and_values_are_those_of_a_file() {
        assert_eq!(
            plain("see [`VehicleSpec::with_tyre`], [`tyres`](Self::tyres) and \\[0, 1\\]; |e|"),
            "see `with_tyre`, `tyres` and [0, 1]; \\|e\\|"
        );
        let constants = BTreeMap::from([("RULES".to_owned(), syn::parse_str::<Expr>("\"paper\"").unwrap())]);
        let value = |text: &str| shown(&syn::parse_str::<Expr>(text).unwrap(), &constants);
        assert_eq!(
            [value("1.0"), value("[0.0, 0.5]"), value("Self { speed: 0.5, latency: 2.0 }")],
            ["1", "[0, 0.5]", "`speed: 0.5`, `latency: 2`"]
        );
        assert_eq!([value("vec![a::RULES.to_owned()]"), value("OTHER")], ["[`paper`]", "its default"]);
        assert_eq!([title("DoubleWishbone"), title("VehicleSpec")], ["Double wishbone", "Vehicle"]);
    }
}
