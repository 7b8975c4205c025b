//! Decoders of others, which may panic on a damaged file.

use std::any::Any;
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    /// Whether this thread decodes, so that nothing is printed of a panic.
    static DECODING: Cell<bool> = const { Cell::new(false) };
}

/// Decodes a stranger's file with a library that may panic on it, as parquet 60 does on pages that are shorter than they say.
///
/// # Errors
/// The text of the panic, which is not printed.
pub fn decoding<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let print = take_hook();
        set_hook(Box::new(move |panic| {
            if !DECODING.get() {
                print(panic);
            }
        }));
    });
    let before = DECODING.replace(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    DECODING.set(before);
    done.map_err(|panic| format!("it can't be decoded: {}", panic_text(&*panic)))
}

/// The message of a panic that was caught.
#[must_use]
pub fn panic_text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<&str>().copied().map(str::to_owned);
    text.or_else(|| panic.downcast_ref::<String>().cloned()).unwrap_or_else(|| "no message".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_a_decoder_is_its_text() {
        assert_eq!(decoding(|| 7), Ok(7));
        let empty: &[u8] = std::hint::black_box(&[]);
        let told = decoding(|| empty[3]).unwrap_err();
        assert!(told.starts_with("it can't be decoded: index out of bounds"), "{told}");
        assert!(!DECODING.get());
    }
}
