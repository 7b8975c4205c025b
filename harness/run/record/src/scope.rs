//! What a run covers, in words: a part of a suite must not look like the whole, nor a tuned planner like the plain one.

use std::collections::BTreeMap;

/// A selector or list of parameters is cut beyond this number of characters; `run.json` has the whole.
const MOST: usize = 80;

/// A planner with the parameters that it was given, which are not its defaults: `pid 0.1.0 (speed=5)`.
#[must_use]
pub fn planner_with_params(planner: &str, params: &BTreeMap<String, String>) -> String {
    if params.is_empty() {
        return planner.to_owned();
    }
    let all: Vec<String> = params.iter().map(|(name, value)| format!("{name}={value}")).collect();
    format!("{planner} ({})", cut(&all.join(" ")))
}

/// A suite with what was chosen of it, if that is not all of it: `vb-100, 20 of 1000 tasks: w001-w002`. `tasks` is the number
/// of tasks chosen, `of` that of the whole suite if it is known.
#[must_use]
pub fn suite_with_selection(suite: &str, tasks: u64, of: u64, selector: Option<&str>) -> String {
    if selector.is_none() && of == tasks {
        return suite.to_owned();
    }
    let which = selector.map_or_else(String::new, |s| format!(": {}", cut(s)));
    format!("{suite}, {tasks} of {of} tasks{which}")
}

fn cut(text: &str) -> String {
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_a_suite_and_given_parameters_are_named_and_the_whole_needs_no_word() {
        let whole = suite_with_selection("vb-100", 1000, 1000, None);
        let part = suite_with_selection("vb-100", 20, 1000, Some("w001-w002"));
        assert_eq!(whole, "vb-100");
        assert_eq!(part, "vb-100, 20 of 1000 tasks: w001-w002");
        let params = BTreeMap::from([("speed".to_owned(), "5".to_owned())]);
        assert_eq!(planner_with_params("pid 0.1.0", &params), "pid 0.1.0 (speed=5)");
        assert_eq!(planner_with_params("pid 0.1.0", &BTreeMap::new()), "pid 0.1.0");
        let long = suite_with_selection("s", 1, 2, Some(&"w001/t00,".repeat(100)));
        assert!(long.chars().count() < 120 && long.ends_with('…'), "{long}");
    }
}
