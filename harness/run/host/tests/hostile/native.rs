//! Native planners that do harm in their process, and libraries that are none.

use vb_host::FaultCode::{self, *};

use crate::Ends::{self, *};
use crate::{Case, Source, case};

fn harm(name: &'static str, what: &'static str, ends: Ends, code: FaultCode, says: &'static str) -> Case {
    case(name, Source::Harm(what), ends, code, says)
}

fn library(name: &'static str, text: &'static str, code: FaultCode, says: &'static str) -> Case {
    case(name, Source::C(text), Load, code, says)
}

pub fn table() -> Vec<Case> {
    let everywhere = [ends(), without_end(), lies(), libraries()].concat();
    // What follows is told by Linux's means.
    if cfg!(target_os = "linux") { [everywhere, too_much()].concat() } else { everywhere }
}

fn ends() -> Vec<Case> {
    vec![
        harm("a segfault", "segfault", Step, Crashed, "signal 11"),
        harm("a segfault in init", "segfault", Init, Crashed, "signal 11"),
        harm("a segfault as it is opened", "segfault", Load, Crashed, "signal 11"),
        harm("a native abort", "abort", Step, Crashed, "signal 6"),
        harm("a native abort in init", "abort", Init, Crashed, "signal 6"),
        harm("a native exit", "exit", Step, Crashed, "code 3"),
        harm("a native exit in init", "exit", Init, Crashed, "code 3"),
        harm("a native exit as it is opened", "exit", Load, Crashed, "code 3"),
        harm("an exit that says all is well", "exit-0", Step, Crashed, "code 0"),
        harm("an exit in init that says all is well", "exit-0", Init, Crashed, "code 0"),
        harm("an arithmetic exception", "fpe", Step, Crashed, "signal 8"),
        harm("an instruction that is none", "ill", Step, Crashed, "signal 4"),
        harm("memory freed twice", "double-free", Step, Crashed, "signal 6"),
        // It ends with code 1, or aborts where the standard library checks who owns descriptors: in builds without
        // optimisation.
        harm("all descriptors closed", "close", Step, Crashed, ""),
    ]
}

fn without_end() -> Vec<Case> {
    vec![
        harm("a native endless loop", "spin", Step, Hung, "1500"),
        harm("a native endless loop in init", "spin", Init, Hung, "1500"),
        harm("a native endless loop as it is opened", "spin", Load, Hung, "1500"),
        harm("a long sleep", "sleep", Step, Hung, "1500"),
        harm("a long sleep in init", "sleep", Init, Hung, "1500"),
        harm("a process that stops itself", "stop", Step, Hung, "1500"),
        harm("native endless lines of log", "talk", Step, Hung, "1500"),
        harm("endless text on standard error", "scream", Step, Hung, "1500"),
    ]
}

fn too_much() -> Vec<Case> {
    vec![
        harm("a native memory bomb", "memory", Step, OutOfMemory, "67108864"),
        harm("a native memory bomb in init", "memory", Init, OutOfMemory, "67108864"),
        harm("a native memory bomb as it is opened", "memory", Load, OutOfMemory, "67108864"),
        harm("memory shared with nobody", "shared", Step, Error, "no such memory"),
        harm("memory that grows downwards", "downwards", Step, Error, "no such memory"),
        harm("a native recursion as it is opened", "stack", Load, StackOverflow, "overflowed its stack"),
        harm("a native recursion", "stack", Step, StackOverflow, "overflowed its stack"),
    ]
}

/// System calls that planners don't get, where the kernel has seccomp.
pub fn confined() -> Vec<Case> {
    let closed = "it can't be opened";
    vec![
        harm("a fork bomb", "fork", Step, ImportDenied, "the system call clone (fork)"),
        harm("a fork bomb as it is opened", "fork", Load, ImportDenied, "the system call clone (fork)"),
        harm("another program", "exec", Step, ImportDenied, "the system call execve"),
        harm("a socket", "socket", Step, ImportDenied, "the system call socket"),
        harm("a socket as it is opened", "socket", Load, ImportDenied, "the system call socket"),
        harm("a signal to the harness", "kill", Step, ImportDenied, "the system call kill"),
        harm("a look into the harness", "trace", Step, ImportDenied, "the system call ptrace"),
        harm("a write into the harness", "poke", Step, ImportDenied, "the system call process_vm_writev"),
        harm("memory shared with others", "share", Step, ImportDenied, "the system call shmget"),
        harm("an alarm", "alarm", Step, ImportDenied, "the system call setitimer"),
        harm("a file removed", "remove", Step, ImportDenied, "the system call unlinkat"),
        harm("the password file", "passwd", Step, Error, closed),
        harm("the password file in init", "passwd", Init, InitFailed, closed),
        harm("a file written", "write", Step, Error, closed),
        harm("a file written in init", "write", Init, InitFailed, closed),
        harm("a library opened later", "library", Step, Error, closed),
        harm("a thread left behind", "thread", Step, Error, "no thread"),
        harm("a thread left behind in init", "thread", Init, InitFailed, "no thread"),
        harm("a handler of signals", "handler", Step, Error, "no handler"),
        harm("a handler of signals in init", "handler", Init, InitFailed, "no handler"),
        harm("limits raised", "limits", Step, Error, "no other limits"),
        harm("limits raised in init", "limits", Init, InitFailed, "no other limits"),
        harm("limits of the harness", "parents-limits", Step, Error, "it is refused"),
        harm("limits of the harness in init", "parents-limits", Init, InitFailed, "it is refused"),
        harm("signals asked for", "own", Step, Error, "it is refused"),
        harm("another signal asked for", "signal", Step, Error, "it is refused"),
        harm("signals asked for by a flag", "async", Step, Error, "it is refused"),
        harm("a larger pipe", "pipe", Step, Error, "it is refused"),
        harm("a life after the harness", "survive", Step, Error, "it is refused"),
        harm("a life after the harness in init", "survive", Init, InitFailed, "it is refused"),
        harm("a process that can be looked into", "dumpable", Step, Error, "it is refused"),
        harm("a filter by another call", "filter-prctl", Step, Error, "it is refused"),
        harm("a filter of its own", "filter", Step, ImportDenied, "the system call seccomp"),
        harm("a filter of its own as it is opened", "filter", Load, ImportDenied, "the system call seccomp"),
        harm("rules of its own for files", "rules", Step, ImportDenied, "landlock_restrict_self"),
        harm("rules of its own as it is opened", "rules", Load, ImportDenied, "landlock_restrict_self"),
        harm("a signal to the harness as it is opened", "kill", Load, ImportDenied, "the system call kill"),
        harm("a signal with a word", "queue", Step, ImportDenied, "the system call rt_sigqueueinfo"),
        harm("a handle on the harness", "pidfd", Step, ImportDenied, "the system call pidfd_open"),
        harm("an end that looks like another's", "raise-kill", Step, ImportDenied, "the system call tgkill"),
        harm("an end in init that looks like another's", "raise-kill", Init, ImportDenied, "tgkill"),
        harm("an end that looks like a user's", "raise-term", Step, ImportDenied, "the system call tgkill"),
        harm("an alarm as it is opened", "alarm", Load, ImportDenied, "the system call setitimer"),
        harm("another program as it is opened", "exec", Load, ImportDenied, "the system call execve"),
        harm("a look into the harness as it is opened", "trace", Load, ImportDenied, "ptrace"),
        harm("a write into the harness as it is opened", "poke", Load, ImportDenied, "process_vm_writev"),
        harm("memory shared as it is opened", "share", Load, ImportDenied, "the system call shmget"),
        harm("a file removed as it is opened", "remove", Load, ImportDenied, "the system call unlinkat"),
        harm("a library opened in init", "library", Init, InitFailed, closed),
        harm("its own file opened again", "itself", Step, Error, closed),
        harm("the folder of libraries", "folder", Step, Error, closed),
        harm("the environment", "environment", Step, Error, "first variable: none"),
        harm("the environment in init", "environment", Init, InitFailed, "first variable: none"),
    ]
}

fn lies() -> Vec<Case> {
    vec![
        harm("bytes that are no message", "garbage", Step, Protocol, ""),
        harm("text where a message is due", "text", Step, Protocol, "print to standard error"),
        harm("a forged message before the due one", "twice", Step, Protocol, "`ready`"),
        // The limit of the output and what a message may have beside.
        harm("a message that is too long", "huge", Step, InvalidOutput, "1114112"),
        harm("a native steering that is no number", "nan", Step, InvalidOutput, "steering is NaN"),
        harm("a native infinite throttle", "inf", Step, InvalidOutput, "throttle is inf"),
        harm("a native gear that there isn't", "gear", Step, InvalidOutput, "gear is 7; want forward (0)"),
        harm("a native flood of debug data", "flood", Step, InvalidOutput, "1114112"),
        harm("a list of debug data that isn't there", "nowhere", Step, Crashed, "signal 11"),
        harm("a failure without a word", "mute", Step, Error, "step returned -1 without a message"),
        harm("a failure with a word on the terminal", "escape", Step, Error, "no way"),
    ]
}

fn libraries() -> Vec<Case> {
    vec![
        library("a library without an entry", "const int vb_planner_nothing = 1;", NotAPlugin, ""),
        library(
            "a library for another version",
            "const vb_planner_functions vb_planner_entry = {sizeof(vb_planner_functions), 0, 3, 0, 0, 0};",
            AbiMismatch,
            "0.3",
        ),
        library(
            "a library with a smaller entry",
            "const vb_planner_functions vb_planner_entry = {16, 1, 0, 0, 0, 0};",
            AbiMismatch,
            "16 bytes",
        ),
        library(
            "a library without functions",
            "const vb_planner_functions vb_planner_entry = {sizeof(vb_planner_functions), 1, 0, 0, 0, 0};",
            AbiMismatch,
            "no function init",
        ),
        library(
            "a library that wants functions that nobody has",
            "int nobody_has_this(void);
             static int32_t init(const vb_task *t, const vb_host *h, void **p, vb_error *e) { return nobody_has_this(); }
             static int32_t step(void *p, const vb_observation *o, const vb_host *h, vb_command *c, vb_error *e)
             { return 1; }
             static void end(void *p) {}
             VB_PLANNER_EXPORT(init, step, end);",
            Unloadable,
            "nobody_has_this",
        ),
    ]
}
