//! The guide shows this example as it is.

use std::path::Path;

fn read(path: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

#[test]
fn the_planner_of_the_guide_is_this_example() {
    let guide = read("../../docs/writing-a-planner.md");
    let shown = guide.split("```rust\n").nth(1).expect("a block of Rust").split("```").next().unwrap();
    assert_eq!(shown, read("src/lib.rs"));
}
