//! Signals that are told to the harness. Planners can't change them: `rt_sigaction` is refused.

use std::io;
use std::mem;
use std::ptr;
use std::sync::atomic::{AtomicI32, AtomicUsize, Ordering};

use libc::{c_int, c_void, siginfo_t};

/// For the handler of forbidden system calls.
static PROTOCOL: AtomicI32 = AtomicI32::new(-1);

/// Bytes of memory that the planner may have.
static MEMORY: AtomicUsize = AtomicUsize::new(0);

/// Has a fault told as one of memory where an eighth of this is not to be had any more.
pub(super) fn expect_memory(bytes: u64) {
    MEMORY.store(usize::try_from(bytes).unwrap_or(usize::MAX), Ordering::Relaxed);
}

/// Has a forbidden system call reported as a message to the descriptor `protocol`, and a stack that is full as a word on
/// standard error.
pub(super) fn handle(protocol: i32) -> io::Result<()> {
    PROTOCOL.store(protocol, Ordering::Relaxed);
    install(libc::SIGSYS, denied, 0)?;
    // A full stack can't hold the handler's frame.
    let stack: &'static mut [u8] = Box::leak(vec![0; 64 << 10].into_boxed_slice());
    let stack =
        libc::stack_t { ss_sp: stack.as_mut_ptr().cast::<c_void>(), ss_flags: 0, ss_size: stack.len() };
    // SAFETY: the memory stays for ever and nothing else uses it.
    if unsafe { libc::sigaltstack(&raw const stack, ptr::null_mut()) } != 0 {
        return Err(io::Error::last_os_error());
    }
    // The handler of Rust's runtime takes itself out by `rt_sigaction`, which fails here: this one takes itself out
    // when it is called, and the fault that comes again ends the process.
    install(libc::SIGSEGV, crashed, libc::SA_RESETHAND)?;
    install(libc::SIGBUS, crashed, libc::SA_RESETHAND)
}

type Handler = extern "C" fn(c_int, *mut siginfo_t, *mut c_void);

fn install(signal: c_int, handler: Handler, flags: c_int) -> io::Result<()> {
    // SAFETY: zero is a valid value of the struct, and the handlers do only what is safe in one.
    let done = unsafe {
        let mut action: libc::sigaction = mem::zeroed();
        action.sa_sigaction = handler as *const () as usize;
        action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK | flags;
        libc::sigaction(signal, &raw const action, ptr::null_mut())
    };
    if done == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

/// The part of `siginfo_t` that SIGSYS fills, on 64-bit Linux (`bits/types/siginfo_t.h`).
#[repr(C)]
struct SigSys {
    signal: i32,
    error: i32,
    code: i32,
    pad: i32,
    address: *const c_void,
    call: i32,
    arch: u32,
}

/// Sends the failure `denied` with the number of the call and ends the process.
extern "C" fn denied(_: c_int, info: *mut siginfo_t, _: *mut c_void) {
    const START: &[u8] = b"\x81\xa5error\x82\xa4kind\xa6denied\xa7message\xa4";
    const DIGITS: usize = 4;
    let mut frame = [0u8; 4 + START.len() + DIGITS];
    frame[0] = (START.len() + DIGITS) as u8;
    frame[4..4 + START.len()].copy_from_slice(START);
    // SAFETY: the kernel hands over the signal's data, which are a `SigSys` for SIGSYS.
    let mut number = unsafe { (*info.cast::<SigSys>()).call }.clamp(0, 9999);
    for digit in frame[4 + START.len()..].iter_mut().rev() {
        *digit = b'0' + (number % 10) as u8;
        number /= 10;
    }
    // SAFETY: both are safe in a signal handler.
    unsafe {
        libc::write(PROTOCOL.load(Ordering::Relaxed), frame.as_ptr().cast(), frame.len());
        libc::_exit(1);
    }
}

/// Says so if the stack is full: memory near the stack pointer isn't there; or if the memory is used up: nobody looked at
/// a null pointer. Then the fault comes again.
extern "C" fn crashed(_: c_int, info: *mut siginfo_t, context: *mut c_void) {
    /// A function's frame, or the pages that compilers touch one after the other to reserve a larger one.
    const NEAR: usize = 64 << 10;
    const STACK: &[u8] = b"planner worker: the planner has overflowed its stack\n";
    const FULL: &[u8] = b"planner worker: the planner has used up its memory\n";
    // SAFETY: the kernel hands over the address of the fault and the registers.
    let (address, stack) = unsafe {
        let registers = &(*context.cast::<libc::ucontext_t>()).uc_mcontext;
        #[cfg(target_arch = "x86_64")]
        let stack = registers.gregs[libc::REG_RSP as usize] as usize;
        #[cfg(target_arch = "aarch64")]
        let stack = registers.sp as usize;
        ((*info).si_addr() as usize, stack)
    };
    let text = if address.abs_diff(stack) < NEAR {
        STACK
    } else if is_full() {
        FULL
    } else {
        return;
    };
    // SAFETY: safe in a signal handler.
    unsafe { libc::write(2, text.as_ptr().cast(), text.len()) };
}

/// Whether an eighth of the planner's memory is refused. It is asked for and not used; the process ends anyway.
fn is_full() -> bool {
    let bytes = MEMORY.load(Ordering::Relaxed) / 8;
    let (access, kind) = (libc::PROT_READ | libc::PROT_WRITE, libc::MAP_PRIVATE | libc::MAP_ANONYMOUS);
    // SAFETY: a new mapping at a place of the system's choice changes no other.
    bytes > 0 && unsafe { libc::mmap(ptr::null_mut(), bytes, access, kind, -1, 0) } == libc::MAP_FAILED
}
