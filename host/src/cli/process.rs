//! What the process of a command line needs before it begins: one heap, and an end that leaves nothing behind.

/// One heap for all threads, who take little from it: a heap of its own takes 64 MB of addresses for each, which may be
/// all that a limit leaves.
#[cfg(target_env = "gnu")]
#[allow(unsafe_code, reason = "a setting of the C library, before there are threads")]
fn one_heap() {
    // SAFETY: no other thread runs yet; where the setting is refused, all works with more addresses.
    unsafe { libc::mallopt(libc::M_ARENA_MAX, 1) };
}

#[cfg(not(target_env = "gnu"))]
fn one_heap() {}

/// Makes the process ready; called once, by its first thread.
pub fn prepare() {
    one_heap();
    // Without a handler an interrupt would leave temporary files behind; if none can be set, that is all that is lost.
    let _ = ctrlc::set_handler(|| crate::write::interrupted());
}
