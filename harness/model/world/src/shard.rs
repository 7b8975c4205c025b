//! Parts of the tasks of a run, for many machines that know nothing of each other.

use std::collections::BTreeSet;
use std::fmt;

use vb_files::sha256;

use crate::TaskId;

/// The environment variable that says how many shards there are, where the scheduler doesn't.
pub const SHARDS_VAR: &str = "VB_SHARDS";
const MOST: u32 = 1_000_000;

/// One of several parts of the tasks of a run. Whole worlds are dealt out, so that each is loaded by one machine alone, in the
/// order of a hash of their names: worlds of one level, which often follow each other, are spread over the shards, and the
/// numbers of worlds of any two shards differ by one at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    index: u32,
    of: u32,
    dealt: u64,
}

/// A text or an environment that says no shard.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ShardError {
    /// The text is no shard.
    #[error("{text:?} is no shard: write 3/8 for the third of eight, or auto in a job of an array")]
    Syntax {
        /// The text.
        text: String,
    },
    /// There is no such shard.
    #[error("there is no shard {index} of {of}: they are counted from 1, to {MOST} at most")]
    Range {
        /// The number of the shard.
        index: u64,
        /// The number of shards.
        of: u64,
    },
    /// No scheduler has said anything.
    #[error(
        "auto: this is no job of an array that is known: none of SLURM_ARRAY_TASK_ID, JOB_COMPLETION_INDEX (Kubernetes) and \
         AWS_BATCH_JOB_ARRAY_INDEX is set (write 3/8 for the third of eight)"
    )]
    NoArray,
    /// A variable of the scheduler is missing, or is no number.
    #[error(
        "auto: {variable} is {value} beside {beside}: it must be a number (write 3/8 for the third of eight)"
    )]
    Variable {
        /// The name of the variable.
        variable: &'static str,
        /// The value; `not set` without one.
        value: String,
        /// The variable that told which scheduler it is.
        beside: &'static str,
    },
    /// The numbers of a Slurm array don't tell the shards of all.
    #[error(
        "auto: the array {first}-{last} has {count} jobs, and shards can be told from one without gaps only that begins at 0 or 1 \
         (for some jobs of a larger array write --shard $SLURM_ARRAY_TASK_ID/N)"
    )]
    Gaps {
        /// The first number.
        first: u64,
        /// The last number.
        last: u64,
        /// How many there are.
        count: u64,
    },
}

impl Shard {
    /// The shard of this number, counted from 1, of so many.
    ///
    /// # Errors
    /// Returns [`ShardError::Range`] if there is no such shard.
    pub fn new(index: u64, of: u64) -> Result<Self, ShardError> {
        let number = |n: u64| u32::try_from(n).ok().filter(|n| (1..=MOST).contains(n));
        match (number(index), number(of)) {
            (Some(index), Some(of)) if index <= of => Ok(Self { index, of, dealt: 0 }),
            _ => Err(ShardError::Range { index, of }),
        }
    }

    /// Reads `3/8`.
    ///
    /// # Errors
    /// Returns an error if the text is no shard.
    pub fn parse(text: &str) -> Result<Self, ShardError> {
        let number = |s: &str| s.trim().parse::<u64>().ok();
        let (index, of) = text
            .split_once('/')
            .and_then(|(index, of)| Some((number(index)?, number(of)?)))
            .ok_or_else(|| ShardError::Syntax { text: text.to_owned() })?;
        Self::new(index, of)
    }

    /// The shard that a job of an array of Slurm, Kubernetes or AWS Batch is to do, as its environment says: `variable` returns
    /// the value of an environment variable.
    ///
    /// Kubernetes doesn't tell how many jobs there are; [`SHARDS_VAR`] must.
    ///
    /// # Errors
    /// Returns an error if it doesn't say so.
    pub fn from_environment(variable: impl Fn(&str) -> Option<String>) -> Result<Self, ShardError> {
        let read = |name: &'static str, beside: &'static str| {
            let value = variable(name);
            value.as_deref().and_then(|v| v.trim().parse::<u64>().ok()).ok_or_else(|| ShardError::Variable {
                variable: name,
                value: value.map_or_else(|| "not set".to_owned(), |v| format!("{v:?}")),
                beside,
            })
        };
        let set = |name: &str| variable(name).is_some();
        // https://slurm.schedmd.com/job_array.html
        const SLURM: &str = "SLURM_ARRAY_TASK_ID";
        // https://kubernetes.io/docs/concepts/workloads/controllers/job/#completion-mode
        const KUBERNETES: &str = "JOB_COMPLETION_INDEX";
        // https://docs.aws.amazon.com/batch/latest/userguide/job_env_vars.html
        const AWS_BATCH: &str = "AWS_BATCH_JOB_ARRAY_INDEX";
        if set(SLURM) {
            let index = read(SLURM, SLURM)?;
            let [first, last, count] =
                ["SLURM_ARRAY_TASK_MIN", "SLURM_ARRAY_TASK_MAX", "SLURM_ARRAY_TASK_COUNT"]
                    .map(|v| read(v, SLURM));
            let (first, last, count) = (first?, last?, count?);
            if first > 1 || last.checked_sub(first).is_none_or(|jobs| jobs + 1 != count) || index < first {
                return Err(ShardError::Gaps { first, last, count });
            }
            return Self::new(index - first + 1, count);
        }
        if set(KUBERNETES) {
            return Self::new(read(KUBERNETES, KUBERNETES)?.saturating_add(1), read(SHARDS_VAR, KUBERNETES)?);
        }
        if set(AWS_BATCH) {
            let size = read("AWS_BATCH_JOB_ARRAY_SIZE", AWS_BATCH)?;
            return Self::new(read(AWS_BATCH, AWS_BATCH)?.saturating_add(1), size);
        }
        Err(ShardError::NoArray)
    }

    /// The same shard where so many worlds of other runs were dealt before, so that many runs that are dealt one after the other
    /// make shards of one size.
    #[must_use]
    pub fn after(self, worlds: u64) -> Self {
        Self { dealt: worlds, ..self }
    }

    /// The number of the shard, from 1.
    #[must_use]
    pub fn index(&self) -> u32 {
        self.index
    }

    /// The number of shards.
    #[must_use]
    pub fn of(&self) -> u32 {
        self.of
    }

    /// The name of the shard's folder, e.g. `shard-0003-of-0008`: names are sorted as the shards are.
    #[must_use]
    pub fn folder(&self) -> String {
        format!("shard-{:04}-of-{:04}", self.index, self.of)
    }

    /// Those of the tasks that are in this shard, in the same order.
    #[must_use]
    pub fn tasks(&self, tasks: &[TaskId]) -> Vec<TaskId> {
        let names: BTreeSet<&str> = tasks.iter().map(|t| t.world()).collect();
        // In the order of the hashes; the name tells apart what no hash does.
        let worlds: BTreeSet<(String, &str)> =
            names.into_iter().map(|world| (sha256(world.as_bytes()), world)).collect();
        let (of, own) = (u64::from(self.of), u64::from(self.index - 1));
        let dealt = worlds.into_iter().zip(self.dealt..);
        let mine: BTreeSet<&str> =
            dealt.filter(|(_, k)| k % of == own).map(|((_, world), _)| world).collect();
        tasks.iter().filter(|t| mine.contains(t.world())).cloned().collect()
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tasks(worlds: u64) -> Vec<TaskId> {
        let task = |w: u64, t: u64| TaskId::new(&format!("w{w:03}"), &format!("t{t:02}")).unwrap();
        (1..=worlds).flat_map(|w| (0..3).map(move |t| task(w, t))).collect()
    }

    fn shards(of: u64) -> impl Iterator<Item = Shard> {
        (1..=of).map(move |k| Shard::new(k, of).unwrap())
    }

    #[test]
    fn each_task_is_in_one_shard_whole_worlds_stay_together_and_sizes_differ_by_one_world() {
        let all = tasks(100);
        for of in [1, 2, 7, 100, 130] {
            let parts: Vec<_> = shards(of).map(|s| s.tasks(&all)).collect();
            let mut joined: Vec<_> = parts.concat();
            joined.sort();
            assert_eq!(joined, all, "{of}");
            let worlds: Vec<BTreeSet<_>> =
                parts.iter().map(|p| p.iter().map(|t| t.world().to_owned()).collect()).collect();
            assert_eq!(worlds.iter().map(BTreeSet::len).sum::<usize>(), 100, "{of}: a world is in one shard");
            let sizes = worlds.iter().map(BTreeSet::len);
            assert!(sizes.clone().max().unwrap() - sizes.min().unwrap() <= 1, "{of}");
            assert!(parts.iter().all(|p| p.is_sorted()), "{of}");
        }
    }

    #[test]
    fn a_shard_is_the_same_on_every_machine() {
        // The order of the hashes by `printf w001 | sha256sum` and so on: w005, w004, w003, w006, w002, w001.
        let tasks = Shard::parse("1/3").unwrap().tasks(&tasks(6));
        let worlds: BTreeSet<_> = tasks.iter().map(|t| t.world()).collect();
        assert_eq!((worlds, tasks.len()), (BTreeSet::from(["w005", "w006"]), 6));
    }

    #[test]
    fn runs_that_are_dealt_one_after_the_other_fill_the_shards_evenly() {
        // Three runs of five worlds over seven shards: 15 worlds, so two or three each.
        let all = tasks(5);
        let sizes: Vec<usize> =
            shards(7).map(|s| (0..3).map(|run| s.after(run * 5).tasks(&all).len() / 3).sum()).collect();
        assert_eq!(sizes, [3, 2, 2, 2, 2, 2, 2]);
    }

    #[test]
    fn a_text_is_a_shard_or_tells_why_not() {
        assert_eq!(Shard::parse("3/8").unwrap().to_string(), "3/8");
        assert_eq!(Shard::parse("3/8").unwrap().folder(), "shard-0003-of-0008");
        for text in ["", "3", "3/", "/8", "a/8", "3/8/9", "-1/8", "1.5/8"] {
            let told = Shard::parse(text).unwrap_err().to_string();
            assert!(told.contains("is no shard: write 3/8"), "{text}: {told}");
        }
        for text in ["0/8", "9/8", "1/0", "1/1000001"] {
            let told = Shard::parse(text).unwrap_err().to_string();
            assert!(told.starts_with("there is no shard"), "{text}: {told}");
        }
    }

    /// The shard in an environment of these variables, or what is wrong with it.
    fn auto(variables: &[(&str, &str)]) -> String {
        let find = |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, v)| (*v).to_owned());
        Shard::from_environment(find).map_or_else(|e| e.to_string(), |s| s.to_string())
    }

    #[test]
    fn schedulers_say_which_job_of_an_array_it_is() {
        let slurm = |id, min, max, count| {
            auto(&[
                ("SLURM_ARRAY_TASK_ID", id),
                ("SLURM_ARRAY_TASK_MIN", min),
                ("SLURM_ARRAY_TASK_MAX", max),
                ("SLURM_ARRAY_TASK_COUNT", count),
            ])
        };
        assert_eq!(slurm("3", "1", "8", "8"), "3/8");
        assert_eq!(slurm("0", "0", "7", "8"), "1/8");
        // Some jobs of an array, begun again: the whole can't be seen.
        assert!(slurm("3", "3", "7", "2").contains("the array 3-7 has 2 jobs"));
        assert!(slurm("3", "1", "7", "4").contains("the array 1-7 has 4 jobs"));
        assert!(slurm("3", "3", "3", "1").contains("the array 3-3 has 1 jobs"));
        assert!(slurm("x", "1", "8", "8").contains("SLURM_ARRAY_TASK_ID is \"x\""));
        assert_eq!(auto(&[("JOB_COMPLETION_INDEX", "7"), ("VB_SHARDS", "8")]), "8/8");
        assert!(
            auto(&[("JOB_COMPLETION_INDEX", "7")])
                .contains("VB_SHARDS is not set beside JOB_COMPLETION_INDEX")
        );
        assert!(
            auto(&[("JOB_COMPLETION_INDEX", "8"), ("VB_SHARDS", "8")]).contains("there is no shard 9 of 8")
        );
        assert_eq!(auto(&[("AWS_BATCH_JOB_ARRAY_INDEX", "0"), ("AWS_BATCH_JOB_ARRAY_SIZE", "8")]), "1/8");
        assert!(auto(&[("VB_SHARDS", "8")]).contains("no job of an array"));
    }
}
