//! A process that was stopped and goes on: Ctrl-Z and `fg`, `docker pause`, a laptop that slept.
//!
//! Linux then ends `epoll_wait` with EINTR (signal(7)), on which RustDDS 0.15.1 leaves the loops of
//! both its threads: the node would be deaf and mute from there on, and nobody would say so. This
//! `epoll_wait` is linked in before that of the C library; for it an interruption is a wait that
//! ended without events, which every loop here bears. Signals are heard through a socket.
#![allow(unsafe_code, reason = "nothing else reaches the loops of RustDDS")]

use std::io;

/// As epoll_wait(2), but never interrupted.
#[unsafe(no_mangle)]
unsafe extern "C" fn epoll_wait(
    epoll: libc::c_int,
    events: *mut libc::epoll_event,
    most: libc::c_int,
    timeout_ms: libc::c_int,
) -> libc::c_int {
    // SAFETY: the caller vouches for the events; no mask of signals is the same as none given.
    let count = unsafe { libc::epoll_pwait(epoll, events, most, timeout_ms, std::ptr::null()) };
    let interrupted = count < 0 && io::Error::last_os_error().kind() == io::ErrorKind::Interrupted;
    if interrupted { 0 } else { count }
}
