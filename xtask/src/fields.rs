//! `cargo xtask fields`: the reference of all fields of a vehicle file (`docs/vehicle-fields.md`) from the types that read it and their
//! comments in `harness/model/vehicle/src`.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use syn::{
    Attribute, Expr, Fields, GenericArgument, Item, ItemEnum, ItemStruct, Lit, Meta, PathArguments, Type,
};

use crate::run::Failure;

/// The page, and the marks between which it is made.
const PAGE: &str = "docs/vehicle-fields.md";
const MARKS: [&str; 2] = ["<!-- made: fields -->", "<!-- end of fields -->"];
const SOURCES: &str = "harness/model/vehicle/src";
/// The type of a whole file.
const ROOT: &str = "VehicleSpec";
/// The list of tyre models, a macro, and the enum that it makes.
const TYRES: [&str; 2] = ["tyre/mod.rs", "TyreSpec"];

/// Writes the page.
pub(crate) fn fields() -> Result<(), Failure> {
    let text = page(crate::root())?;
    std::fs::write(crate::root().join(PAGE), text)
        .map_err(|e| Failure::new(format!("can't write {PAGE}: {e}")))
}

/// The page with what lies between its marks replaced.
fn page(root: &Path) -> Result<String, Failure> {
    let found = std::fs::read_to_string(root.join(PAGE))
        .map_err(|e| Failure::new(format!("can't read {PAGE}: {e}")))?;
    let lost = || Failure::new(format!("{PAGE} lacks a line {} or {}", MARKS[0], MARKS[1]));
    let (before, rest) = found.split_once(MARKS[0]).ok_or_else(lost)?;
    let (_, after) = rest.split_once(MARKS[1]).ok_or_else(lost)?;
    let made = Types::read(&root.join(SOURCES))?.sections()?;
    Ok(format!("{before}{}\n\n{made}{}{after}", MARKS[0], MARKS[1]))
}

/// The types of the sources, by name.
#[derive(Default)]
struct Types {
    structs: BTreeMap<String, ItemStruct>,
    enums: BTreeMap<String, ItemEnum>,
    /// Functions without arguments and `Default::default` of types: the expressions that they return.
    values: BTreeMap<String, Expr>,
    /// Name, variant's data and comment of each tyre model.
    tyres: Vec<[String; 3]>,
}

impl Types {
    fn read(folder: &Path) -> Result<Self, Failure> {
        let mut types = Self::default();
        let mut folders = vec![folder.to_owned()];
        while let Some(folder) = folders.pop() {
            let failed = |e: std::io::Error| Failure::new(format!("can't read {}: {e}", folder.display()));
            for entry in std::fs::read_dir(&folder).map_err(failed)? {
                let path = entry.map_err(failed)?.path();
                if path.is_dir() {
                    folders.push(path);
                } else if path.extension().is_some_and(|e| e == "rs") {
                    let text = std::fs::read_to_string(&path).map_err(failed)?;
                    if path.ends_with(TYRES[0]) {
                        types.tyres = tyres(&text);
                    }
                    let file = syn::parse_file(&text)
                        .map_err(|e| Failure::new(format!("{}: {e}", path.display())))?;
                    file.items.into_iter().for_each(|item| types.take(item));
                }
            }
        }
        if types.tyres.is_empty() {
            return Err(Failure::new(format!("{SOURCES}/{} has no list of tyre models", TYRES[0])));
        }
        Ok(types)
    }

    fn take(&mut self, item: Item) {
        let returned = |block: &syn::Block| match block.stmts.as_slice() {
            [syn::Stmt::Expr(value, None)] => Some(value.clone()),
            _ => None,
        };
        match item {
            Item::Struct(s) if is_read(&s.attrs) => {
                self.structs.insert(s.ident.to_string(), s);
            }
            Item::Enum(e) if is_read(&e.attrs) => {
                self.enums.insert(e.ident.to_string(), e);
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
    fn sections(&self) -> Result<String, Failure> {
        let mut out = String::new();
        let mut order = vec![ROOT.to_owned()];
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

    /// The section of a type, and the types that it names.
    fn section(&self, name: &str) -> Result<(String, Vec<String>), Failure> {
        let mut named = Vec::new();
        let mut out = format!("## {}\n\n", title(name));
        if name == TYRES[1] {
            out.push_str("The first field, `model`, selects the model; its own fields follow.\n\n| `model` | meaning | fields |\n|---|---|---|\n");
            for [model, data, comment] in &self.tyres {
                let _ = writeln!(out, "| `{model}` | {comment} | {} |", link(data));
                named.push(data.clone());
            }
            out.push('\n');
        } else if let Some(s) = self.structs.get(name) {
            let _ = write!(
                out,
                "{}\n\n| field | type | if absent | meaning |\n|---|---|---|---|\n",
                comment(&s.attrs)
            );
            self.rows(&mut out, "", &s.fields, &mut named)?;
            out.push('\n');
        } else if let Some(e) = self.enums.get(name) {
            let _ = write!(out, "{}\n\n", comment(&e.attrs));
            self.variants(&mut out, e, &mut named)?;
        } else {
            return Err(Failure::new(format!("{SOURCES} has no type {name}")));
        }
        Ok((out, named))
    }

    /// A row for each field.
    fn rows(
        &self,
        out: &mut String,
        before: &str,
        fields: &Fields,
        named: &mut Vec<String>,
    ) -> Result<(), Failure> {
        for field in fields {
            let name = field.ident.as_ref().map(ToString::to_string).unwrap_or_default();
            let name = serde(&field.attrs, "rename").unwrap_or(name);
            let absent = match serde(&field.attrs, "default") {
                None => "required".to_owned(),
                Some(function) if function.is_empty() => self.default_of(&field.ty),
                Some(function) => match self.values.get(&function) {
                    Some(value) => shown(value),
                    None => return Err(Failure::new(format!("{SOURCES} has no function {function}"))),
                },
            };
            let kind = self.kind(&field.ty, named)?;
            let mut meaning = comment(&field.attrs);
            if meaning.is_empty() {
                meaning = "joint of the linkage".to_owned();
            }
            let _ = writeln!(out, "| {before}`{name}` | {kind} | {absent} | {meaning} |");
        }
        Ok(())
    }

    fn variants(&self, out: &mut String, e: &ItemEnum, named: &mut Vec<String>) -> Result<(), Failure> {
        let snake = |v: &syn::Variant| snake(&v.ident.to_string());
        let Some(tag) = serde(&e.attrs, "tag") else {
            out.push_str("| value | meaning |\n|---|---|\n");
            for v in &e.variants {
                let usual = v.attrs.iter().any(|a| a.path().is_ident("default"));
                let _ = writeln!(
                    out,
                    "| `{}`{} | {} |",
                    snake(v),
                    if usual { " (if absent)" } else { "" },
                    comment(&v.attrs)
                );
            }
            out.push('\n');
            return Ok(());
        };
        let _ = write!(out, "| `{tag}` | meaning | fields |\n|---|---|---|\n");
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
            let _ = writeln!(out, "| `{}` | {} | {fields} |", snake(v), comment(&v.attrs));
        }
        if e.variants.iter().any(|v| matches!(v.fields, Fields::Named(_)) && !v.fields.is_empty()) {
            let _ =
                write!(out, "\n| `{tag}` | field | type | if absent | meaning |\n|---|---|---|---|---|\n");
            for v in e.variants.iter().filter(|v| matches!(v.fields, Fields::Named(_))) {
                self.rows(out, &format!("`{}` | ", snake(v)), &v.fields, named)?;
            }
        }
        out.push('\n');
        Ok(())
    }

    /// A type as people read it.
    fn kind(&self, ty: &Type, named: &mut Vec<String>) -> Result<String, Failure> {
        let unknown = || {
            Failure::new(format!(
                "{SOURCES}: no words for a type of a field; add them to xtask/src/fields.rs"
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
                let last = path.path.segments.last().ok_or_else(unknown)?;
                let mut inner = Vec::new();
                if let PathArguments::AngleBracketed(arguments) = &last.arguments {
                    for argument in &arguments.args {
                        if let GenericArgument::Type(ty) = argument {
                            inner.push(self.kind(ty, named)?);
                        }
                    }
                }
                let name = last.ident.to_string();
                Ok(match (name.as_str(), inner.as_slice()) {
                    ("f64", _) => "number".to_owned(),
                    ("String", _) => "text".to_owned(),
                    ("bool", _) => "`true` or `false`".to_owned(),
                    ("Point", _) => "[x, y, z]".to_owned(),
                    ("Schema", _) => "1".to_owned(),
                    ("Option", [inner]) => inner.clone(),
                    ("Vec", [inner]) => format!("list of {inner}"),
                    ("BTreeMap", [_, inner]) => format!("map from names to {inner}"),
                    _ => {
                        named.push(name.clone());
                        link(&name)
                    }
                })
            }
            _ => Err(unknown()),
        }
    }

    /// What a field is that may be left out.
    fn default_of(&self, ty: &Type) -> String {
        let Type::Path(path) = ty else { return "zeros".to_owned() };
        let name = path.path.segments.last().map(|s| s.ident.to_string()).unwrap_or_default();
        match name.as_str() {
            "f64" => "0".to_owned(),
            "bool" => "`false`".to_owned(),
            "Option" => "none".to_owned(),
            "Vec" | "BTreeMap" => "empty".to_owned(),
            name => {
                let usual = self.enums.get(name).and_then(|e| {
                    e.variants.iter().find(|v| v.attrs.iter().any(|a| a.path().is_ident("default")))
                });
                match (usual, self.values.get(name)) {
                    (Some(v), _) => format!("`{}`", snake(&v.ident.to_string())),
                    (None, Some(value)) => shown(value),
                    (None, None) => "its defaults".to_owned(),
                }
            }
        }
    }
}

/// Whether files are read into a type.
fn is_read(attributes: &[Attribute]) -> bool {
    let derives = attributes.iter().filter(|a| a.path().is_ident("derive"));
    derives
        .filter_map(|a| a.meta.require_list().ok())
        .any(|list| list.tokens.to_string().contains("Deserialize"))
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

/// An expression as a value of a file.
fn shown(value: &Expr) -> String {
    let number = |text: String| text.strip_suffix(".0").map_or(text.clone(), str::to_owned);
    match value {
        Expr::Lit(syn::ExprLit { lit: Lit::Float(f), .. }) => number(f.base10_digits().to_owned()),
        Expr::Array(array) => format!("[{}]", array.elems.iter().map(shown).collect::<Vec<_>>().join(", ")),
        Expr::Struct(s) => {
            let field = |f: &syn::FieldValue| match &f.member {
                syn::Member::Named(name) => format!("`{name}: {}`", shown(&f.expr)),
                syn::Member::Unnamed(_) => shown(&f.expr),
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

fn link(name: &str) -> String {
    let title = title(name);
    format!("[{}](#{})", title.to_lowercase(), title.to_lowercase().replace(' ', "-"))
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
    fn the_page_is_what_follows_from_the_types_and_their_comments() {
        let root = crate::root();
        let found = std::fs::read_to_string(root.join(PAGE)).unwrap();
        assert!(
            found == page(root).unwrap(),
            "{PAGE} is not what follows from {SOURCES}; run `cargo xtask fields`"
        );
    }

    #[test]
    fn the_page_has_every_field_that_a_shipped_vehicle_uses() {
        let root = crate::root();
        let page = std::fs::read_to_string(root.join(PAGE)).unwrap();
        for entry in std::fs::read_dir(root.join("tasks/vehicles")).unwrap() {
            let path = entry.unwrap().path();
            let text = std::fs::read_to_string(&path).unwrap();
            let mut lines = text.lines().peekable();
            while let Some(line) = lines.next() {
                let line = line.split('#').next().unwrap().trim_start_matches([' ', '-', '{']);
                let Some((field, _)) = line.split_once(':') else { continue };
                // Names of tyres are the authors' own; sentences of texts have blanks.
                let own = lines.peek().is_some_and(|next| next.trim_start().starts_with("model:"));
                let text = field.contains([' ', '\"', '[']);
                assert!(own || text || page.contains(&format!("`{field}`")), "{}: {field}", path.display());
            }
        }
    }

    #[test]
    fn comments_lose_their_links_and_values_are_those_of_a_file() {
        assert_eq!(
            plain("see [`VehicleSpec::with_tyre`], [`tyres`](Self::tyres) and \\[0, 1\\]; |e|"),
            "see `with_tyre`, `tyres` and [0, 1]; \\|e\\|"
        );
        let value = |text: &str| shown(&syn::parse_str::<Expr>(text).unwrap());
        assert_eq!(
            [value("1.0"), value("[0.0, 0.5]"), value("Self { speed: 0.5, latency: 2.0 }")],
            ["1", "[0, 0.5]", "`speed: 0.5`, `latency: 2`"]
        );
        assert_eq!(
            (title("DoubleWishbone"), link("VehicleSpec")),
            ("Double wishbone".into(), "[vehicle](#vehicle)".into())
        );
    }
}
