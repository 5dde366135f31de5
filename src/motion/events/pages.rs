//! Large pages for the memory of large arenas.
//!
//! The events of an arena of a million discs jump all over a hundred megabytes; with pages of 4 kB
//! the processor looks up nearly every address in tables that are themselves far away. Linux gives
//! pages of 2 MB to memory that asks for them before it is touched. One of the few files with
//! unsafe code: it calls the system. It changes no content, and nothing depends on its success.
#![allow(unsafe_code, reason = "measured at 1e6 discs: 0.8 of the time, carom bench gas")]

/// Memory smaller than this gains nothing, bytes.
const LARGE: usize = 1 << 22;

/// An empty vector with room for so many, in large pages if that is much memory.
pub fn with_room_for<T>(count: usize) -> Vec<T> {
    let items = Vec::with_capacity(count);
    ask_for_large_pages(&items);
    items
}

/// Makes room for one more; what grows doubles, and asks anew.
#[inline(always)]
pub fn make_room_for_one<T>(items: &mut Vec<T>) {
    if items.len() == items.capacity() {
        grow(items);
    }
}

#[cold]
fn grow<T>(items: &mut Vec<T>) {
    items.reserve(items.len().max(16));
    ask_for_large_pages(items);
}

#[cfg(target_os = "linux")]
fn ask_for_large_pages<T>(items: &Vec<T>) {
    const PAGE: usize = 4096;
    let bytes = items.capacity() * size_of::<T>();
    if bytes < LARGE {
        return;
    }
    let start = (items.as_ptr() as usize).next_multiple_of(PAGE);
    let length = (items.as_ptr() as usize + bytes - start) / PAGE * PAGE;
    // SAFETY: the range lies within what the vector owns, and the advice changes no content.
    // Where there are no large pages the system says so, and all goes on as before.
    unsafe { libc::madvise(start as *mut libc::c_void, length, libc::MADV_HUGEPAGE) };
}

#[cfg(not(target_os = "linux"))]
fn ask_for_large_pages<T>(_: &Vec<T>) {
    let _ = LARGE;
}
