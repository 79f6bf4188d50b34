//! Pointers of C as slices and references.

/// `count` elements; none for a null pointer with elements, an odd address, or more bytes than memory can have.
///
/// # Safety
/// Where it is not null, `start` points to `count` initialised elements that nobody writes while the slice is in
/// use.
pub unsafe fn slice<'a, T>(start: *const T, count: usize) -> Option<&'a [T]> {
    if count == 0 {
        return Some(&[]);
    }
    let fits = count.checked_mul(size_of::<T>()).is_some_and(|bytes| bytes <= isize::MAX as usize);
    if start.is_null() || !start.is_aligned() || !fits {
        return None;
    }
    // SAFETY: not null, aligned, small enough; the caller answers for the elements.
    Some(unsafe { core::slice::from_raw_parts(start, count) })
}

/// The same to write to.
///
/// # Safety
/// As for [`slice`], and nobody else reads the elements either.
pub unsafe fn slice_mut<'a, T>(start: *mut T, count: usize) -> Option<&'a mut [T]> {
    if count == 0 {
        return Some(&mut []);
    }
    let fits = count.checked_mul(size_of::<T>()).is_some_and(|bytes| bytes <= isize::MAX as usize);
    if start.is_null() || !start.is_aligned() || !fits {
        return None;
    }
    // SAFETY: not null, aligned, small enough; the caller answers for the elements.
    Some(unsafe { core::slice::from_raw_parts_mut(start, count) })
}

/// Pixels from the first to the last of a frame of which the rows are `stride` pixels apart.
pub fn pixels_of(width: usize, height: usize, stride: usize) -> usize {
    stride.saturating_mul(height.saturating_sub(1)).saturating_add(width)
}

/// A text that ends with a zero byte, of at most 64 bytes; none where it is null, longer or no UTF-8.
///
/// # Safety
/// Where it is not null, `start` points to bytes up to and including a zero.
pub unsafe fn text<'a>(start: *const core::ffi::c_char) -> Option<&'a str> {
    const MOST: usize = 64;
    if start.is_null() {
        return None;
    }
    let start = start.cast::<u8>();
    for length in 0..=MOST {
        // SAFETY: no byte before this one is the zero, so that this one is still of the text.
        if unsafe { start.add(length).read() } == 0 {
            // SAFETY: these bytes were just read.
            return core::str::from_utf8(unsafe { core::slice::from_raw_parts(start, length) }).ok();
        }
    }
    None
}
