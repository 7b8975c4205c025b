//! XML as a tree that can be rewritten.

use crate::ImportError;

/// The most nodes of a file.
const NODES: u32 = 500_000;

/// An element, with the line on which it stands.
#[derive(Clone, Debug, Default)]
pub(crate) struct Element {
    /// Whether it belongs to xacro.
    pub(crate) macros: bool,
    pub(crate) name: String,
    pub(crate) attributes: Vec<(String, String)>,
    pub(crate) children: Vec<Element>,
    pub(crate) text: String,
    pub(crate) file: String,
    pub(crate) line: u32,
}

impl Element {
    pub(crate) fn parse(text: &str, file: &str) -> Result<Self, ImportError> {
        let options =
            roxmltree::ParsingOptions { allow_dtd: false, nodes_limit: NODES, ..Default::default() };
        let document = roxmltree::Document::parse_with_options(text, options).map_err(|e| {
            ImportError::new(
                file,
                format!("line {}", e.pos().row),
                format!("invalid XML ({e}); correct the file"),
            )
        })?;
        let root = convert(document.root_element(), &document, file, 0)?;
        if root.name != "robot" {
            let problem = format!(
                "<{}>, but URDF starts with <robot>; SDF and MJCF are not supported (convert them to URDF)",
                root.name
            );
            return Err(ImportError::new(file, "", problem));
        }
        Ok(root)
    }

    pub(crate) fn at(&self) -> String {
        format!("line {}", self.line)
    }

    pub(crate) fn fail<T>(&self, problem: impl std::fmt::Display) -> Result<T, ImportError> {
        Err(self.error(problem))
    }

    pub(crate) fn error(&self, problem: impl std::fmt::Display) -> ImportError {
        let name = if self.macros { format!("xacro:{}", self.name) } else { self.name.clone() };
        ImportError::new(&self.file, self.at(), format!("<{name}>: {problem}"))
    }

    pub(crate) fn get(&self, key: &str) -> Option<&str> {
        self.attributes.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str())
    }

    pub(crate) fn need(&self, key: &str) -> Result<&str, ImportError> {
        self.get(key).ok_or_else(|| self.error(format!("the attribute {key:?} is missing")))
    }

    pub(crate) fn child(&self, name: &str) -> Option<&Element> {
        self.children.iter().find(|c| !c.macros && c.name == name)
    }

    pub(crate) fn named<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a Element> {
        self.children.iter().filter(move |c| !c.macros && c.name == name)
    }

    pub(crate) fn number(&self, key: &str) -> Result<f64, ImportError> {
        let text = self.need(key)?;
        let x = text.trim().parse().ok().filter(|x: &f64| x.is_finite());
        x.ok_or_else(|| self.error(format!("{key}={text:?} is not a number")))
    }

    /// Three numbers; zeros if the attribute is absent.
    pub(crate) fn triple(&self, key: &str) -> Result<[f64; 3], ImportError> {
        let Some(text) = self.get(key) else { return Ok([0.0; 3]) };
        let numbers: Vec<f64> =
            text.split_whitespace().filter_map(|w| w.parse().ok()).filter(|x: &f64| x.is_finite()).collect();
        numbers.try_into().or_else(|_| self.fail(format!("{key}={text:?} is not three numbers")))
    }
}

fn convert(
    node: roxmltree::Node,
    document: &roxmltree::Document,
    file: &str,
    depth: usize,
) -> Result<Element, ImportError> {
    if depth > 64 {
        return Err(ImportError::new(file, "", "nested more than 64 levels deep"));
    }
    let mut children = Vec::new();
    for c in node.children().filter(roxmltree::Node::is_element) {
        children.push(convert(c, document, file, depth + 1)?);
    }
    let tag = node.tag_name();
    Ok(Element {
        macros: tag.namespace().is_some_and(|n| n.contains("xacro")),
        name: tag.name().to_owned(),
        attributes: node.attributes().map(|a| (a.name().to_owned(), a.value().to_owned())).collect(),
        children,
        text: node.text().unwrap_or("").trim().to_owned(),
        file: file.to_owned(),
        line: document.text_pos_at(node.range().start).row,
    })
}
