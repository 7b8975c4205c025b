//! Expansion of xacro: properties, arguments, includes, macros, conditions.

use super::expr::{Value, evaluate};
use super::xml::Element;
use crate::{ImportError, MOST, Notes, Options};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Depth of includes and of macros within macros.
const DEEPEST: usize = 32;
/// Elements after expansion.
const ELEMENTS: usize = 200_000;
/// Levels above a file in which a package's folder is searched.
const LEVELS: usize = 6;

/// Macro: parameters and body.
#[derive(Clone, Debug)]
struct Macro {
    parameters: Vec<Parameter>,
    body: Element,
}

#[derive(Clone, Debug)]
struct Parameter {
    name: String,
    default: Option<String>,
    /// Whether it is an element, and whether its children are meant.
    block: bool,
    children: bool,
}

/// Values and blocks that are visible at a place.
#[derive(Clone, Debug, Default)]
struct Scope {
    values: BTreeMap<String, Value>,
    blocks: BTreeMap<String, Vec<Element>>,
}

/// The state of an expansion.
pub(crate) struct Xacro<'a> {
    arguments: BTreeMap<String, String>,
    macros: BTreeMap<String, Macro>,
    stack: Vec<PathBuf>,
    elements: usize,
    depth: usize,
    data: Option<&'a Path>,
    notes: &'a mut Notes,
}

/// Expands a file.
pub(crate) fn expand(
    file: &Path,
    root: &Element,
    options: &Options,
    notes: &mut Notes,
) -> Result<Element, ImportError> {
    let mut x = Xacro {
        arguments: options.arguments.iter().cloned().collect(),
        macros: BTreeMap::new(),
        stack: vec![std::fs::canonicalize(file).unwrap_or_else(|_| file.to_owned())],
        elements: 0,
        depth: 0,
        data: options.data.as_deref(),
        notes,
    };
    let mut scope = Scope::default();
    let children = x.children(&root.children, &mut scope)?;
    let mut attributes = root.attributes.clone();
    for (_, v) in &mut attributes {
        *v = x.substitute(v, &scope, root)?;
    }
    Ok(Element { attributes, children, ..root.clone() })
}

/// Adds the way out to a message.
fn unread<T>(at: &Element, problem: impl std::fmt::Display) -> Result<T, ImportError> {
    at.fail(format!(
        "{problem}; expand the file with ROS's `xacro FILE > robot.urdf`, and convert the result"
    ))
}

impl Xacro<'_> {
    fn children(&mut self, list: &[Element], scope: &mut Scope) -> Result<Vec<Element>, ImportError> {
        let mut out = Vec::new();
        for e in list {
            self.element(e, scope, &mut out)?;
        }
        Ok(out)
    }

    fn element(&mut self, e: &Element, scope: &mut Scope, out: &mut Vec<Element>) -> Result<(), ImportError> {
        self.elements += 1;
        if self.elements > ELEMENTS {
            return e.fail(format!("more than {ELEMENTS} elements after expansion"));
        }
        if !e.macros {
            let mut attributes = e.attributes.clone();
            for (_, v) in &mut attributes {
                *v = self.substitute(v, scope, e)?;
            }
            let text = self.substitute(&e.text, scope, e)?;
            let children = self.children(&e.children, scope)?;
            out.push(Element { attributes, text, children, ..e.clone() });
            return Ok(());
        }
        match e.name.as_str() {
            "property" => self.property(e, scope)?,
            "arg" => {
                let name = self.substitute(e.need("name")?, scope, e)?;
                if !self.arguments.contains_key(&name)
                    && let Some(default) = e.get("default")
                {
                    let value = self.substitute(default, scope, e)?;
                    self.arguments.insert(name, value);
                }
            }
            "macro" => {
                let name = e.need("name")?.trim_start_matches("xacro:").to_owned();
                let parameters = parameters(e.get("params").unwrap_or(""));
                self.macros.insert(name, Macro { parameters, body: e.clone() });
            }
            "include" => self.include(e, scope, out)?,
            "if" | "unless" => {
                let text = self.substitute(e.need("value")?, scope, e)?;
                let Some(truth) = Value::of(&text).truth() else {
                    return e.fail(format!("the condition {text:?} is neither true nor false"));
                };
                if truth == (e.name == "if") {
                    out.extend(self.children(&e.children, scope)?);
                }
            }
            "insert_block" => {
                let name = self.substitute(e.need("name")?, scope, e)?;
                match scope.blocks.get(&name) {
                    Some(block) => {
                        let block = block.clone();
                        out.extend(self.children(&block, scope)?);
                    }
                    None => return e.fail(format!("no block has the name {name:?}")),
                }
            }
            "element" | "attribute" | "call" => return unread(e, "is not supported"),
            _ => self.call(e, scope, out)?,
        }
        Ok(())
    }

    fn property(&mut self, e: &Element, scope: &mut Scope) -> Result<(), ImportError> {
        let name = self.substitute(e.need("name")?, scope, e)?;
        match (e.get("value"), e.get("default")) {
            (Some(value), _) => {
                let value = self.value(value, scope, e)?;
                scope.values.insert(name, value);
            }
            (None, Some(default)) => {
                if !scope.values.contains_key(&name) {
                    let value = self.value(default, scope, e)?;
                    scope.values.insert(name, value);
                }
            }
            (None, None) => {
                scope.blocks.insert(name, e.children.clone());
            }
        }
        Ok(())
    }

    fn call(&mut self, e: &Element, scope: &mut Scope, out: &mut Vec<Element>) -> Result<(), ImportError> {
        let Some(found) = self.macros.get(&e.name).cloned() else {
            return e
                .fail("no macro of this name is defined; include its file, or give its folder with --data");
        };
        self.depth += 1;
        if self.depth > DEEPEST {
            return e.fail(format!("macros within macros are more than {DEEPEST} levels deep (a loop?)"));
        }
        let mut inner = scope.clone();
        let mut blocks = e.children.iter();
        for p in &found.parameters {
            if p.block {
                let Some(block) = blocks.next() else {
                    return e.fail(format!("the block {:?} is missing", p.name));
                };
                let content = if p.children { block.children.clone() } else { vec![block.clone()] };
                let content = self.children(&content, scope)?;
                inner.blocks.insert(p.name.clone(), content);
                continue;
            }
            let value = match (e.get(&p.name), &p.default) {
                (Some(text), _) => self.value(text, scope, e)?,
                (None, Some(default)) => {
                    // `^` takes the value of the caller, `^|x` with x for absent ones.
                    match default.strip_prefix('^') {
                        Some(rest) => match (scope.values.get(&p.name), rest.strip_prefix('|')) {
                            (Some(v), _) => v.clone(),
                            (None, Some(text)) => self.value(text, scope, e)?,
                            (None, None) => {
                                return e.fail(format!("{:?} is not defined by the caller", p.name));
                            }
                        },
                        None => self.value(default, scope, e)?,
                    }
                }
                (None, None) => return e.fail(format!("the parameter {:?} is missing", p.name)),
            };
            inner.values.insert(p.name.clone(), value);
        }
        out.extend(self.children(&found.body.children, &mut inner)?);
        self.depth -= 1;
        Ok(())
    }

    fn include(&mut self, e: &Element, scope: &mut Scope, out: &mut Vec<Element>) -> Result<(), ImportError> {
        let name = match self.substitute(e.need("filename")?, scope, e) {
            Ok(name) => name,
            // A package that is not installed: macros of it that are used are missed where they are called.
            Err(err) if err.problem.contains("the package") => {
                self.notes.dropped(format!("{}: {}: {}", e.file, e.at(), err.problem));
                return Ok(());
            }
            Err(err) => return Err(err),
        };
        let folder = self.stack.last().and_then(|f| f.parent()).unwrap_or(Path::new(".")).to_owned();
        let path = if Path::new(&name).is_absolute() { PathBuf::from(&name) } else { folder.join(&name) };
        let simulation =
            name.contains("gazebo") || name.ends_with("empty.urdf") || name.contains("empty_world");
        if !path.is_file() {
            if simulation || e.get("optional").is_some_and(|o| Value::of(o).truth() == Some(true)) {
                self.notes.dropped(format!(
                    "{}: {}: include of {name:?}, which is not there",
                    e.file,
                    e.at()
                ));
                return Ok(());
            }
            return e.fail(format!(
                "{name:?} does not exist; add the file, or give the folder of its package with --data"
            ));
        }
        let full = std::fs::canonicalize(&path).map_err(|err| ImportError::reading(&path, &err))?;
        if self.stack.contains(&full) {
            return e.fail(format!("{name:?} includes itself"));
        }
        if self.stack.len() >= DEEPEST {
            return e.fail(format!("includes are more than {DEEPEST} levels deep"));
        }
        let text = vb_files::read_text(&full, MOST).map_err(|err| ImportError::reading(&full, &err))?;
        let root = Element::parse(&text, &path.display().to_string())?;
        self.stack.push(full);
        // Properties and macros of an included file are those of the including one.
        out.extend(self.children(&root.children, scope)?);
        self.stack.pop();
        Ok(())
    }

    /// A text with its expressions, as a value.
    fn value(&mut self, text: &str, scope: &Scope, at: &Element) -> Result<Value, ImportError> {
        let t = text.trim();
        if let Some(inner) = t.strip_prefix("${").and_then(|t| t.strip_suffix('}'))
            && !inner.contains(['{', '}'])
        {
            return match evaluate(inner, &scope.values) {
                Ok(v) => Ok(v),
                Err(e) => unread(at, format!("${{{inner}}}: {e}")),
            };
        }
        let text = self.substitute(text, scope, at)?;
        let text = text.trim();
        // As in macro parameters: 'text' in quotes.
        let quoted = text.len() > 1 && text.starts_with('\'') && text.ends_with('\'');
        Ok(if quoted { Value::Text(text[1..text.len() - 1].to_owned()) } else { Value::of(text) })
    }

    /// Replaces `${…}` and `$(…)`.
    fn substitute(&mut self, text: &str, scope: &Scope, at: &Element) -> Result<String, ImportError> {
        let mut out = String::new();
        let mut rest = text;
        while let Some(k) = rest.find('$') {
            out.push_str(&rest[..k]);
            rest = &rest[k..];
            let (open, close) = match rest.as_bytes().get(1) {
                Some(b'{') => ('{', '}'),
                Some(b'(') => ('(', ')'),
                Some(b'$') => {
                    out.push('$');
                    rest = &rest[2..];
                    continue;
                }
                _ => {
                    out.push('$');
                    rest = &rest[1..];
                    continue;
                }
            };
            let mut depth = 0;
            let end = rest.char_indices().skip(1).find(|(_, c)| {
                depth += i32::from(*c == open) - i32::from(*c == close);
                depth == 0
            });
            let Some((end, _)) = end else { return at.fail(format!("{text:?} has an open bracket")) };
            let inner = &rest[2..end];
            let value = if open == '{' {
                match evaluate(inner, &scope.values) {
                    Ok(v) => v.text(),
                    Err(e) => return unread(at, format!("${{{inner}}}: {e}")),
                }
            } else {
                let inner = self.substitute(inner, scope, at)?;
                self.command(&inner, scope, at)?
            };
            out.push_str(&value);
            rest = &rest[end + 1..];
        }
        out.push_str(rest);
        Ok(out)
    }

    /// A substitution of ROS's launch files.
    fn command(&mut self, text: &str, scope: &Scope, at: &Element) -> Result<String, ImportError> {
        let (word, rest) = text.trim().split_once(char::is_whitespace).unwrap_or((text.trim(), ""));
        let rest = rest.trim();
        match word {
            "arg" => match self.arguments.get(rest) {
                Some(v) => Ok(v.clone()),
                None => {
                    at.fail(format!("the argument {rest:?} has no value; give one with --arg {rest}=VALUE"))
                }
            },
            // The environment of the machine is no part of a robot's description: defaults count.
            "optenv" => Ok(rest.split_once(char::is_whitespace).map_or("", |(_, d)| d).trim().to_owned()),
            "env" => unread(at, format!("$(env {rest}) depends on the machine")),
            "find" => self.package(rest, at),
            "dirname" => {
                let folder = self.stack.last().and_then(|f| f.parent());
                Ok(folder.unwrap_or(Path::new(".")).display().to_string())
            }
            "eval" => match evaluate(rest, &scope.values) {
                Ok(v) => Ok(v.text()),
                Err(e) => unread(at, format!("$(eval {rest}): {e}")),
            },
            other => unread(at, format!("$({other} …) is not supported")),
        }
    }

    /// The folder of a package: above the file, beside one of the folders above it, or in the folder that the user gave.
    fn package(&self, name: &str, at: &Element) -> Result<String, ImportError> {
        match package(name, self.stack.last().map(PathBuf::as_path), self.data) {
            Some(folder) => Ok(folder.display().to_string()),
            None => at.fail(format!("the package {name:?} is in no folder above the file; give the folder that contains it with --data")),
        }
    }
}

/// The folder of a package of ROS.
pub(crate) fn package(name: &str, file: Option<&Path>, data: Option<&Path>) -> Option<PathBuf> {
    if name.is_empty() || name.contains(['/', '\\']) || name == ".." {
        return None;
    }
    let above = file.into_iter().flat_map(|f| f.ancestors().skip(1).take(LEVELS));
    let mut folders = data.into_iter().chain(above).flat_map(|folder| {
        let own = folder.file_name().is_some_and(|n| n.to_string_lossy() == *name).then(|| folder.to_owned());
        own.into_iter().chain([folder.join(name), folder.join("src").join(name)])
    });
    folders.find(|f| f.is_dir())
}

/// Parameters of a macro: `name`, `name:=default`, `*block`, `**children`.
fn parameters(text: &str) -> Vec<Parameter> {
    let mut words: Vec<String> = Vec::new();
    let (mut word, mut quoted, mut depth) = (String::new(), false, 0_i32);
    for c in text.chars() {
        match c {
            '\'' => quoted = !quoted,
            '{' | '(' => depth += 1,
            '}' | ')' => depth -= 1,
            _ => {}
        }
        if c.is_whitespace() && !quoted && depth <= 0 {
            words.extend((!word.is_empty()).then(|| std::mem::take(&mut word)));
        } else {
            word.push(c);
        }
    }
    words.extend((!word.is_empty()).then_some(word));
    let parameter = |w: &String| {
        let stars = w.chars().take_while(|c| *c == '*').count();
        let (name, default) = match w[stars..].split_once(":=") {
            Some((n, d)) => (n, Some(d.to_owned())),
            None => match w[stars..].split_once('=') {
                Some((n, d)) => (n, Some(d.to_owned())),
                None => (&w[stars..], None),
            },
        };
        Parameter { name: name.to_owned(), default, block: stars > 0, children: stars > 1 }
    };
    words.iter().map(parameter).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn expanded(text: &str) -> Result<Element, ImportError> {
        let text = format!("<robot name=\"r\" xmlns:xacro=\"http://www.ros.org/wiki/xacro\">{text}</robot>");
        let root = Element::parse(&text, "r.xacro").unwrap();
        expand(Path::new("r.xacro"), &root, &Options::default(), &mut Notes::default())
    }

    #[test]
    fn macros_blocks_and_conditions_expand() {
        let robot = expanded(
            "<xacro:property name=\"w\" value=\"0.2\"/><xacro:arg name=\"big\" default=\"$(optenv BIG 0)\"/>\
             <xacro:macro name=\"wheel\" params=\"side y:=${w/2} *pose\"><xacro:if value=\"${side == 'left'}\"><link name=\"${side}_wheel\"/>\
             <joint><xacro:insert_block name=\"pose\"/></joint></xacro:if></xacro:macro>\
             <xacro:wheel side=\"left\"><origin xyz=\"0 ${w*2} 0\"/></xacro:wheel>\
             <xacro:wheel side=\"right\"><origin/></xacro:wheel>\
             <xacro:unless value=\"$(arg big)\"><link name=\"small\"/></xacro:unless>",
        )
        .unwrap();
        let links: Vec<&str> = robot.named("link").filter_map(|l| l.get("name")).collect();
        assert_eq!(links, ["left_wheel", "small"]);
        assert_eq!(robot.child("joint").unwrap().child("origin").unwrap().get("xyz"), Some("0 0.4 0"));
    }

    #[test]
    fn what_is_not_read_names_the_way_out() {
        for (text, says) in [
            ("<link name=\"${load_yaml('x')}\"/>", "xacro FILE > robot.urdf"),
            ("<xacro:call macro=\"x\"/>", "xacro FILE > robot.urdf"),
            ("<xacro:strange/>", "no macro of this name"),
            ("<link name=\"$(arg x)\"/>", "--arg x=VALUE"),
            ("<xacro:include filename=\"$(find no_such_package)/a.xacro\"/><xacro:of_it/>", "--data"),
            ("<xacro:include filename=\"no_such.xacro\"/>", "does not exist"),
            (
                "<xacro:macro name=\"a\" params=\"\"><xacro:a/></xacro:macro><xacro:a/>",
                "levels deep (a loop?)",
            ),
        ] {
            let e = expanded(text).unwrap_err().to_string();
            assert!(e.contains(says) && e.starts_with("r.xacro: line 1") && !e.contains('\n'), "{e}");
        }
    }
}
