//! The projects that `vb-harness plugin new` makes. Planners in other languages than Rust start from the examples of the
//! repository, so what is handed out is what its tests build and drive.
use clap::ValueEnum;

/// The language of a planner's project.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Language {
    /// Rust, with the SDK.
    Rust,
    /// C, compiled with zig.
    C,
    /// Python, with its interpreter in the plugin.
    Python,
    /// Python with NumPy, as a process, which is not ranked.
    Numpy,
    /// JavaScript, with the QuickJS engine in the plugin.
    Js,
}

/// A file of a project.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct File {
    /// Where it lies in the project.
    pub(super) path: &'static str,
    pub(super) content: Vec<u8>,
    pub(super) executable: bool,
}

/// The authors of the examples, who are not those of the new planner.
const AUTHORS: &str = "authors: [The Verti-Bench in Rust developers]";
const WORKFLOW: &str = ".github/workflows/planner.yml";

/// The files of an example, and the interface, which lies beside them by a link that not every copy of the sources has.
macro_rules! example {
    ($example:literal, $($path:literal),*) => {
        [
            ("wit/planner.wit", include_bytes!("../../../../../sdk/wit/v1_0/planner.wit") as &[u8]),
            $(($path, include_bytes!(concat!("../../../../../examples/", $example, "/", $path)) as &[u8])),*
        ]
    };
}

const C: &[(&str, &[u8])] = &example!(
    "pursuit-c",
    "README.md",
    ".gitignore",
    "build.sh",
    "requirements.txt",
    "planner.yaml",
    "planner.c",
    "following.c",
    "following.h",
    "gen/planner_plugin.c",
    "gen/planner_plugin.h",
    "gen/planner_plugin_component_type.o"
);
const PYTHON: &[(&str, &[u8])] = &example!(
    "pursuit-python",
    "README.md",
    ".gitignore",
    "build.sh",
    "requirements.txt",
    "planner.yaml",
    "guest.py",
    "following.py",
    "faults.py"
);
const JS: &[(&str, &[u8])] = &example!(
    "pursuit-js",
    "README.md",
    ".gitignore",
    "build.sh",
    "package.json",
    "planner.yaml",
    "planner.js"
);

/// The SDK for Python, which a project carries along: it is on no package index.
macro_rules! python_sdk {
    ($($file:literal),*) => {
        [$((
            concat!("vertibench_planner/", $file),
            include_str!(concat!("../../../../../sdk/python/src/vertibench_planner/", $file)),
        )),*]
    };
}
const PYTHON_SDK: [(&str, &str); 5] =
    python_sdk!("__init__.py", "_data.py", "_methods.py", "_path.py", "_serve.py");

/// The files of a project for a planner of this name. `sdk` is where Rust finds the SDK: keys and values of a dependency.
pub(super) fn files(language: Language, name: &str, sdk: &str) -> Vec<File> {
    match language {
        Language::Rust => rust(name, sdk),
        Language::C => of_example(C, "pursuit-c", name, "python3 -m pip install -r requirements.txt"),
        Language::Python => {
            of_example(PYTHON, "pursuit-python", name, "python3 -m pip install -r requirements.txt")
        }
        Language::Numpy => numpy(name),
        Language::Js => of_example(JS, "pursuit-js", name, "npm install"),
    }
}

fn of_example(files: &[(&'static str, &[u8])], example: &str, name: &str, install: &str) -> Vec<File> {
    let file = |(path, content): &(&'static str, &[u8])| {
        let content = match std::str::from_utf8(content) {
            Ok(text) => {
                text.replace(example, name).replace(AUTHORS, "authors: [You <you@example.org>]").into()
            }
            Err(_) => content.to_vec(),
        };
        File { path, content, executable: *path == "build.sh" }
    };
    let built = format!("build/{name}.wasm");
    let mut all: Vec<File> = files.iter().map(file).collect();
    all.push(workflow(&[
        install,
        "./build.sh",
        &format!("vb-harness inspect {built}"),
        &format!("vb-harness check {built}"),
        &format!("vb-harness run {built} --tasks w001/t00"),
    ]));
    all
}

/// The GitHub workflow that runs these commands.
fn workflow(commands: &[&str]) -> File {
    let steps: String = commands.iter().map(|command| format!("      - run: {command}\n")).collect();
    let text = include_str!("../../../templates/workflows/script.yml").replace("@STEPS@", &steps);
    File { path: WORKFLOW, content: text.into(), executable: false }
}

fn numpy(name: &str) -> Vec<File> {
    let planner =
        include_str!("../../../../../sdk/python/examples/pursuit.py").replace("pursuit-python", name);
    let readme = include_str!("../../../templates/numpy/README.md").replace("@NAME@", name);
    let own = [
        ("README.md", readme.as_str()),
        (".gitignore", include_str!("../../../templates/numpy/gitignore")),
        ("requirements.txt", include_str!("../../../templates/numpy/requirements.txt")),
        ("planner.py", planner.as_str()),
    ];
    let file = |(path, text): (&'static str, &str)| File { path, content: text.into(), executable: false };
    let mut all: Vec<File> = own.into_iter().chain(PYTHON_SDK).map(file).collect();
    all.push(workflow(&[
        "python3 -m pip install -r requirements.txt",
        "vb-harness inspect \"python3 planner.py\"",
        "vb-harness check \"python3 planner.py\"",
        "vb-harness run \"python3 planner.py\" --tasks w001/t00 --out drive",
        &format!("vb-harness commands drive --out {name}.commands"),
    ]));
    all
}

fn rust(name: &str, sdk: &str) -> Vec<File> {
    let source = include_str!("../../../../../examples/pursuit/src/lib.rs");
    let source = source.replace("name: \"pursuit\"", &format!("name: \"{name}\""));
    let filled = |text: &str| {
        text.replace("@NAME@", name).replace("@CRATE@", &name.replace('-', "_")).replace("@SDK@", sdk)
    };
    [
        ("README.md", filled(include_str!("../../../templates/rust/README.md"))),
        (".gitignore", filled(include_str!("../../../templates/rust/gitignore"))),
        ("Cargo.toml", filled(include_str!("../../../templates/rust/Cargo.toml"))),
        (".cargo/config.toml", filled(include_str!("../../../templates/rust/config.toml"))),
        ("src/lib.rs", source),
        (WORKFLOW, filled(include_str!("../../../templates/workflows/rust.yml"))),
    ]
    .map(|(path, text)| File { path, content: text.into(), executable: false })
    .into()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text<'a>(files: &'a [File], path: &str) -> &'a str {
        let file = files.iter().find(|f| f.path == path).unwrap_or_else(|| panic!("{path} is missing"));
        std::str::from_utf8(&file.content).unwrap()
    }

    #[test]
    fn a_project_bears_its_own_name_and_nothing_of_the_template_is_left() {
        for language in Language::value_variants() {
            let files = files(*language, "swift-fox", "path = \"/sdk\"");
            let of_the_template = ["@NAME@", "@CRATE@", "@SDK@", "@STEPS@", "pursuit-", "\"pursuit\""];
            for file in &files {
                let Ok(content) = std::str::from_utf8(&file.content) else { continue };
                for left in of_the_template {
                    assert!(!content.contains(left), "{language:?} {}: {left}", file.path);
                }
                assert!(!content.contains("in Rust developers"), "{language:?} {}", file.path);
            }
            assert!(text(&files, "README.md").starts_with("# swift-fox\n"));
        }
    }

    #[test]
    fn the_sdk_for_python_is_whole() {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../sdk/python/src/vertibench_planner");
        let names = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|n| n.ends_with(".py")).collect();
        names.sort();
        let carried = PYTHON_SDK.map(|(path, _)| path.trim_start_matches("vertibench_planner/"));
        assert_eq!(names, carried);
    }

    /// What an author reads is what the project's CI does.
    #[test]
    fn the_workflow_runs_the_commands_of_the_readme() {
        for language in Language::value_variants() {
            let files = files(*language, "swift-fox", "path = \"/sdk\"");
            let workflow: serde_json::Value = vb_files::yaml::parse(text(&files, WORKFLOW)).unwrap();
            let steps = workflow["jobs"]["planner"]["steps"].as_array().unwrap();
            let run: Vec<&str> = steps.iter().filter_map(|s| s["run"].as_str()).collect();
            let readme = text(&files, "README.md");
            let told: Vec<&str> = readme.lines().filter_map(|l| l.strip_prefix("$ ")).collect();
            assert_eq!(told.len(), 5, "{language:?}");
            assert!(run.ends_with(&told), "{language:?}: {told:?} in {run:?}");
        }
    }

    #[test]
    fn scripts_are_executable() {
        let files = files(Language::C, "a", "");
        let executable: Vec<&str> = files.iter().filter(|f| f.executable).map(|f| f.path).collect();
        assert_eq!(executable, ["build.sh"]);
    }
}
