//! The name of a task in its suite.

use std::borrow::Borrow;
use std::fmt;
use std::str::FromStr;

use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::check::check_id;
use crate::{Task, World, WorldInfo};

/// The name of a task in its suite, e.g. `w001/t03`: the name of the world, a slash, and the name of the task in the world. Each
/// name has 1 to 32 of a-z, 0-9 and _. The order is that of the text.
#[derive(Clone, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct TaskId(Box<str>);

/// The reason why a text is not the name of a task.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{text:?} is not the name of a task: use WORLD/TASK, each of 1 to 32 of a-z, 0-9 and _ (e.g. w001/t03)"
)]
pub struct TaskIdError {
    /// The first 80 characters of the text.
    text: String,
}

impl TaskId {
    /// The name of the task `task` of the world `world`.
    ///
    /// # Errors
    /// Returns an error if either name is not valid.
    pub fn new(world: &str, task: &str) -> Result<Self, TaskIdError> {
        format!("{world}/{task}").try_into()
    }

    /// The name of the world.
    #[must_use]
    pub fn world(&self) -> &str {
        self.split().0
    }

    /// The name of the task in its world.
    #[must_use]
    pub fn task(&self) -> &str {
        self.split().1
    }

    /// The name as text, `WORLD/TASK`.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    fn split(&self) -> (&str, &str) {
        self.0.split_once('/').expect("a task's name has a slash, which was checked when it was made")
    }
}

impl TryFrom<String> for TaskId {
    type Error = TaskIdError;

    fn try_from(text: String) -> Result<Self, TaskIdError> {
        let parts = text.split_once('/');
        if parts.is_some_and(|(world, task)| check_id(world).is_ok() && check_id(task).is_ok()) {
            return Ok(Self(text.into_boxed_str()));
        }
        Err(TaskIdError { text: text.chars().take(80).collect() })
    }
}

impl FromStr for TaskId {
    type Err = TaskIdError;

    fn from_str(text: &str) -> Result<Self, TaskIdError> {
        text.to_owned().try_into()
    }
}

impl fmt::Display for TaskId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.0)
    }
}

impl fmt::Debug for TaskId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(&self.0, f)
    }
}

impl Borrow<str> for TaskId {
    fn borrow(&self) -> &str {
        &self.0
    }
}

impl PartialEq<str> for TaskId {
    fn eq(&self, other: &str) -> bool {
        *self.0 == *other
    }
}

impl PartialEq<&str> for TaskId {
    fn eq(&self, other: &&str) -> bool {
        *self.0 == **other
    }
}

impl Serialize for TaskId {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(&self.0)
    }
}

impl<'de> Deserialize<'de> for TaskId {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        String::deserialize(from)?.try_into().map_err(D::Error::custom)
    }
}

impl World {
    /// The name in the suite of a task of this world.
    ///
    /// # Panics
    /// Panics if the name of world or task is not valid; see [`World::check`].
    #[must_use]
    pub fn task_id(&self, task: &Task) -> TaskId {
        TaskId::new(&self.id, &task.id).expect("the names of a checked world are valid")
    }
}

impl WorldInfo {
    /// The names in the suite of the world's tasks, in order.
    ///
    /// # Panics
    /// Panics if a name is not valid; [`crate::Suite`] checks them.
    pub fn task_ids(&self) -> impl Iterator<Item = TaskId> {
        let id = |task: &String| TaskId::new(&self.id, task).expect("the names of a checked suite are valid");
        self.tasks.iter().map(id)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_a_task_only_if_both_names_are_valid() {
        let task: TaskId = "w001/t03".parse().unwrap();
        assert_eq!((task.world(), task.task(), task.to_string().as_str()), ("w001", "t03", "w001/t03"));
        assert_eq!(TaskId::new("w001", "t03").unwrap(), task);
        let long = format!("w001/{}", "t".repeat(10_000));
        for odd in ["", "w001", "/t03", "w001/", "w001/t03/x", "W001/t03", "../t03", "w001/t 3", &long] {
            let e = odd.parse::<TaskId>().unwrap_err().to_string();
            assert!(e.contains("WORLD/TASK") && e.len() < 250, "{e}");
            assert!(e.starts_with(&format!("{:?}", odd.chars().take(80).collect::<String>())), "{e}");
        }
        assert!(TaskId::new("w001/t03", "t03").is_err());
    }

    /// Sums over tasks are in this order, so it must be that of the text.
    #[test]
    fn tasks_are_in_the_order_of_their_text() {
        let text = ["a/t2", "a1/t1", "a_/t0", "aa/t0"];
        let mut tasks = text.map(|t| t.parse::<TaskId>().unwrap());
        tasks.reverse();
        tasks.sort();
        assert_eq!(tasks.each_ref().map(TaskId::as_str), text);
        assert!(text.is_sorted());
    }
}
