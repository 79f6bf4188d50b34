//! Memory for the planes of a frame.

/// A plane of `len` cells, in large pages where the system has them: the front touches every row
/// of a frame again and again, and ordinary pages are too many for the processor's page table.
pub fn plane<T: Copy + Default>(len: usize) -> Vec<T> {
    let mut plane = Vec::with_capacity(len);
    ask_for_large_pages(plane.as_mut_ptr(), plane.capacity());
    plane.resize(len, T::default());
    plane
}

#[cfg(target_os = "linux")]
fn ask_for_large_pages<T>(start: *mut T, len: usize) {
    const PAGE: usize = 4096;
    let (from, to) = (start as usize, start as usize + len * size_of::<T>());
    let (first, last) = (from.next_multiple_of(PAGE), to / PAGE * PAGE);
    if first < last {
        // SAFETY: whole pages inside an allocation of ours; the advice changes no content, and
        // where it is refused nothing is lost.
        unsafe { libc::madvise(first as *mut libc::c_void, last - first, libc::MADV_HUGEPAGE) };
    }
}

#[cfg(not(target_os = "linux"))]
fn ask_for_large_pages<T>(_: *mut T, _: usize) {}

#[cfg(test)]
mod tests {
    #[test]
    fn planes_are_zero_and_as_long_as_asked() {
        for len in [0, 1, 1023, 3_000_000] {
            assert_eq!(super::plane::<f32>(len), vec![0.0; len]);
        }
    }
}
