//! The style of plots on paper.

use std::collections::BTreeMap;

/// These rules with the values that variables have where `sheets` are printed, for programs that know neither variables nor media:
/// a figure in a file of its own.
///
/// `sheets` declare variables in `:root{…}`, for light ground first, and those of paper once more within `@media print{`. What is
/// declared nowhere stays as it is.
#[must_use]
pub fn print_style(rules: &[&str], sheets: &[&str]) -> String {
    let mut values = BTreeMap::new();
    for sheet in sheets {
        let print = sheet.split_once("@media print{").map_or("", |(_, print)| print);
        for part in [*sheet, print] {
            let root = part.split_once(":root{").and_then(|(_, rest)| rest.split_once('}'));
            let declared = root.map_or("", |(declared, _)| declared).split(';');
            values
                .extend(declared.filter_map(|d| d.trim().split_once(':')).map(|(k, v)| (k.trim(), v.trim())));
        }
    }
    let mut style = rules.concat();
    for (name, value) in values {
        style = style.replace(&format!("var({name})"), value);
    }
    style
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{PLOT_STYLE, TABLE_STYLE};

    #[test]
    fn variables_have_the_values_of_paper() {
        let sheet = ":root{--a:#111;--b:#222}@media(prefers-color-scheme:dark){:root{--a:#fff;--b:#eee}}@media print{:root{--b:#000}}";
        let style = print_style(&[".x{fill:var(--a)}", ".y{stroke:var(--b);color:var(--c)}"], &[sheet]);
        assert_eq!(style, ".x{fill:#111}.y{stroke:#000;color:var(--c)}");
    }

    #[test]
    fn plots_need_nothing_but_the_variables_of_tables() {
        let style = print_style(&[PLOT_STYLE], &[TABLE_STYLE]);
        assert!(!style.contains("var(") && !style.contains('@'), "{style}");
        assert!(style.contains(".f0{fill:#0068d6}") && style.contains(".level{fill:#000;"), "{style}");
    }
}
