//! `cargo xtask fields`: the references of all fields of files, from the types that read and write them and their comments.

mod macros;
mod types;

use std::path::Path;

use crate::run::Failure;
use types::Types;

/// The marks of a page between which it is made.
const MARKS: [&str; 2] = ["<!-- made: fields -->", "<!-- end of fields -->"];
/// A page with the fields of files.
struct Page {
    file: &'static str,
    formats: &'static [Format],
}

/// A format of files.
struct Format {
    /// The title of its section, with the folder or the file; empty on a page of one format.
    title: &'static str,
    /// A sentence below the title: who writes and who reads such files.
    about: &'static str,
    /// The type of a whole file, and the folders of sources with it and with the types of its fields.
    root: &'static str,
    sources: &'static [&'static str],
}

/// The sources of the generator's rules.
const GENERATOR: &[&str] = &[
    "harness/make/suite/src/generate",
    "harness/make/suite/src/path.rs",
    "harness/make/terrain/src/shaping.rs",
    "harness/model/world/src",
];

const PAGES: [Page; 2] = [
    Page {
        file: "docs/vehicle-fields.md",
        formats: &[Format {
            title: "",
            about: "",
            root: "VehicleSpec",
            sources: &["harness/model/vehicle/src"],
        }],
    },
    Page {
        file: "docs/file-fields.md",
        formats: &[
            Format {
                title: "Rules",
                about: "`tasks/rules`, `--rules`; [scoring](scoring.md).",
                root: "Rules",
                sources: &["harness/run/score/src"],
            },
            Format {
                title: "Soil set",
                about: "`tasks/soils`, `--soils`; [soils](soils.md).",
                root: "SoilSet",
                sources: &["harness/model/sim/src/soil"],
            },
            Format {
                title: "Perception profile",
                about: "`tasks/perception`, `--perception`; [perception](perception.md).",
                root: "ProfileData",
                sources: &["harness/model/sense/src"],
            },
            Format {
                title: "suite.yaml",
                about: "A suite's worlds and their hashes; [worlds](worlds.md).",
                root: "SuiteDocument",
                sources: &["harness/model/world/src"],
            },
            Format {
                title: "world.yaml",
                about: "A world's grid and classes; [worlds](worlds.md).",
                root: "WorldDocument",
                sources: &["harness/model/world/src"],
            },
            Format {
                title: "semantics.yaml",
                about: "A world's terrain classes, friction and soils; [worlds](worlds.md).",
                root: "SemanticsDocument",
                sources: &["harness/model/world/src"],
            },
            Format {
                title: "obstacles.yaml",
                about: "A world's obstacles; [worlds](worlds.md).",
                root: "ObstaclesDocument",
                sources: &["harness/model/world/src"],
            },
            Format {
                title: "tasks.yaml",
                about: "A world's tasks; [worlds](worlds.md).",
                root: "TasksDocument",
                sources: &["harness/model/world/src"],
            },
            Format {
                title: "beds.yaml",
                about: "A world's granular beds; [granular beds](granular.md).",
                root: "BedsDocument",
                sources: &["harness/model/world/src"],
            },
            Format {
                title: "proof.json",
                about: "A suite's solvability certificate, written by `suite prove`; [worlds](worlds.md#solvability-certificates).",
                root: "Proof",
                sources: &["harness/make/suite/src/proof.rs"],
            },
            Format {
                title: "Generator rules",
                about: "`tasks/generator`, `suite generate --params`; [making suites](making-suites.md).",
                root: "GeneratorParams",
                sources: GENERATOR,
            },
            Format {
                title: "Site rules",
                about: "`suite site --site`; [making suites](making-suites.md).",
                root: "SiteParams",
                sources: &["harness/make/suite/src/site", "harness/model/world/src"],
            },
            Format {
                title: "Test bed rules",
                about: "`tasks/generator/testbed.yaml`, `suite testbed --params`; [physical testbed](testbed.md).",
                root: "TestbedParams",
                sources: &[
                    "harness/make/suite/src/testbed",
                    "harness/make/suite/src/path.rs",
                    "harness/make/suite/src/generate",
                    "harness/model/world/src",
                ],
            },
            Format {
                title: "Granular bed rules",
                about: "`tasks/generator/granular.yaml`, `suite generate --granular --params`; [granular beds](granular.md).",
                root: "GranularParams",
                sources: &[
                    "harness/make/suite/src/granular.rs",
                    "harness/make/suite/src/path.rs",
                    "harness/model/world/src",
                ],
            },
            Format {
                title: "Granular material",
                about: "`tasks/soils/granular`, `material` in bed rules; [granular beds](granular.md#materials).",
                root: "MaterialFile",
                sources: &["harness/model/granular/src", "harness/model/world/src"],
            },
            Format {
                title: "Exploration",
                about: "`tasks/exploration`, `dataset explore --rules`; [datasets](datasets.md).",
                root: "Exploration",
                sources: &["harness/make/dataset/src/explore"],
            },
            Format {
                title: "Reward",
                about: "`tasks/rewards`, the environments' `reward`; [environments](environments.md).",
                root: "File",
                sources: &["harness/learn/env/src/reward.rs"],
            },
            Format {
                title: "Curriculum",
                about: "`tasks/curricula`, the environments' `curriculum`; [training](training.md).",
                root: "File",
                sources: &["harness/learn/env/src/curriculum/spec.rs"],
            },
            Format {
                title: "Sweep",
                about: "`sweep run`; [many machines](scale.md).",
                root: "File",
                sources: &[
                    "harness/run/runner/src/sweep",
                    "harness/run/record/src",
                    "harness/run/trial/src/defaults.rs",
                ],
            },
            Format {
                title: "run.json",
                about: "Written by `run`; [results](results.md).",
                root: "RunHeader",
                sources: &["harness/run/record/src"],
            },
            Format {
                title: "tasks.jsonl",
                about: "A line for each task, written by `run`; [results](results.md).",
                root: "TaskRecord",
                sources: &["harness/run/score/src", "harness/model/world/src"],
            },
            Format {
                title: "summary.json",
                about: "Written by `run`; [results](results.md).",
                root: "Summary",
                sources: &["harness/run/score/src", "harness/model/world/src"],
            },
            Format {
                title: "submission.json",
                about: "Written by `submit`; [submissions](leaderboard.md).",
                root: "Manifest",
                sources: &["harness/show/submission/src", "harness/run/score/src", "harness/run/record/src"],
            },
            Format {
                title: "verification.json",
                about: "Written by `verify`; [submissions](leaderboard.md).",
                root: "Verification",
                sources: &["harness/show/submission/src", "harness/run/score/src", "harness/run/record/src"],
            },
            Format {
                title: "dataset.json",
                about: "Written by `dataset drive`, `explore` and `failures`; [datasets](datasets.md).",
                root: "Header",
                sources: &["harness/make/dataset/src", "harness/run/record/src"],
            },
            Format {
                title: "planner.yaml",
                about: "`plugin stamp`; [interface](abi.md#metadata).",
                root: "Document",
                sources: &["harness/cli/src/command/plugin/meta.rs"],
            },
        ],
    },
];

/// The title of the format whose whole file is of a type with a name of its own.
fn titled(root: &str) -> Option<&'static str> {
    let formats = PAGES.iter().flat_map(|page| page.formats);
    let named = formats.filter(|format| !format.title.is_empty() && format.root != "File");
    named.into_iter().find(|format| format.root == root).map(|format| format.title)
}

/// Writes the pages.
pub(crate) fn fields() -> Result<(), Failure> {
    for page in &PAGES {
        let text = page.text(crate::root())?;
        std::fs::write(crate::root().join(page.file), text)
            .map_err(|e| Failure::new(format!("can't write {}: {e}", page.file)))?;
    }
    Ok(())
}

impl Page {
    /// The page with what lies between its marks replaced.
    fn text(&self, root: &Path) -> Result<String, Failure> {
        let file = self.file;
        let found = std::fs::read_to_string(root.join(file))
            .map_err(|e| Failure::new(format!("can't read {file}: {e}")))?;
        let lost = || Failure::new(format!("{file} lacks a line {} or {}", MARKS[0], MARKS[1]));
        let (before, rest) = found.split_once(MARKS[0]).ok_or_else(lost)?;
        let (_, after) = rest.split_once(MARKS[1]).ok_or_else(lost)?;
        let made = self.formats.iter().map(|format| Types::read(root, format)?.sections());
        let made = made.collect::<Result<Vec<_>, _>>()?.concat();
        Ok(format!("{before}{}\n\n{made}{}{after}", MARKS[0], MARKS[1]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pages_are_what_follows_from_the_types_and_their_comments() {
        for page in &PAGES {
            let found = std::fs::read_to_string(crate::root().join(page.file)).unwrap();
            let text = page.text(crate::root()).unwrap();
            assert!(
                found == text,
                "{} is not what follows from its sources; run `cargo xtask fields`",
                page.file
            );
        }
    }

    #[test]
    fn the_page_has_every_field_that_a_shipped_vehicle_uses() {
        let root = crate::root();
        let page = std::fs::read_to_string(root.join(PAGES[0].file)).unwrap();
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
}
