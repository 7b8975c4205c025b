//! The list of formats: a module for each, declared by the list.

use serde::{Deserialize, Serialize};

use crate::format::Files;

/// Makes the formats of a list, the default first. A row has the format's module, which is also its name in
/// `dataset.json`, and its variant, which is also the name of the type of its [`Files`].
macro_rules! formats {
    ($($(#[$doc:meta])* $module:ident $format:ident,)*) => {
        $(mod $module;)*

        /// The format of a dataset's files.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "lowercase")]
        pub enum Format {
            $($(#[$doc])* $format,)*
        }

        impl Format {
            /// All formats, the default first.
            pub const ALL: &[Self] = &[$(Self::$format),*];

            pub(crate) fn files(self) -> &'static dyn Files {
                match self { $(Self::$format => &$module::$format,)* }
            }
        }

        #[cfg(test)]
        const MODULES: &[&str] = &[$(stringify!($module)),*];
    };
}
formats! {
    /// LeRobot's, version 3.0.
    lerobot LeRobot,
}

/// The first format of the list, in which datasets are made.
impl Default for Format {
    fn default() -> Self {
        Self::ALL[0]
    }
}

impl Format {
    pub(crate) fn is_default(&self) -> bool {
        *self == Self::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_name_of_each_format_in_files_is_that_of_its_module() {
        for (format, module) in Format::ALL.iter().zip(MODULES) {
            assert_eq!(serde_json::to_value(format).unwrap(), *module);
        }
    }

    #[test]
    fn files_of_each_format_have_paths_of_their_own() {
        for format in Format::ALL {
            let files = format.files();
            let mut paths: Vec<_> = files.whole_paths().iter().map(std::path::PathBuf::from).collect();
            paths.extend([0, 1].map(|number| files.data_path(number)));
            paths.extend([0, 1].map(|number| files.episodes_path(number)));
            let count = paths.len();
            assert!(paths.iter().all(|path| path.is_relative()), "{format:?}: {paths:?}");
            paths.sort();
            paths.dedup();
            assert_eq!(paths.len(), count, "{format:?}: {paths:?}");
        }
    }
}
