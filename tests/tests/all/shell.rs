//! What shells and `man` know of the command line: docs/results.md.

use std::process::Command;

use vb_tests::Bench;

/// Bash itself completes a command line by the script, as it does when somebody presses the tab key.
#[test]
fn bash_completes_commands_and_options() {
    let bench = Bench::new();
    bench.write("completions.bash", bench.ok(&["completions", "bash"]));
    let complete = |words: &str, at: usize| {
        // The function is the one that the script has told bash of.
        let find = r"f=$(complete -p vb-harness | sed 's/.*-F \([^ ]*\).*/\1/')";
        let script = format!(
            "source completions.bash; {find}; COMP_WORDS=({words}); COMP_CWORD={at}; $f vb-harness \"${{COMP_WORDS[{at}]}}\" \"\"; \
             printf '%s\\n' \"${{COMPREPLY[@]}}\""
        );
        let done = Command::new("bash")
            .args(["--norc", "-c", &script])
            .current_dir(bench.path("."))
            .output()
            .unwrap();
        assert!(done.status.success(), "{done:?}");
        String::from_utf8(done.stdout).unwrap().lines().map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(complete("vb-harness swe", 1), ["sweep"]);
    assert_eq!(complete("vb-harness sweep ru", 2), ["run"]);
    assert_eq!(complete("vb-harness run --sha", 2), ["--shard"]);
    for shell in ["zsh", "fish"] {
        assert!(bench.ok(&["completions", shell]).contains("leaderboard"), "{shell}");
    }
}

#[test]
fn each_command_has_a_manual_page_with_its_exit_codes() {
    let bench = Bench::new();
    bench.ok(&["man", "--out", "man1"]);
    let pages = bench.files("man1");
    let page = |name: &str| String::from_utf8(pages[std::path::Path::new(name)].clone()).unwrap();
    assert!(page("vb-harness.1").contains("Run a planner over a suite"));
    let merge = page("vb-harness-merge.1");
    assert!(merge.contains("some tasks are missing") && merge.contains("\\-\\-suite"), "{merge}");
    assert!(pages.len() > 30, "{}", pages.len());
}
