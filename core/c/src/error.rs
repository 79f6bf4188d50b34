//! Error numbers, which stay for ever, and their texts.

use core::ffi::{CStr, c_char};
use core::fmt::Write;
use skyfront_core::error::Error;

/// No error.
pub const SKYFRONT_OK: i32 = 0;
/// A parameter is out of its bounds.
pub const SKYFRONT_ERROR_PARAMETER: i32 = 1;
/// The image has an unsupported size.
pub const SKYFRONT_ERROR_SIZE: i32 = 2;
/// Memory or an array is too short.
pub const SKYFRONT_ERROR_LENGTH: i32 = 3;
/// No pixel is a finite number.
pub const SKYFRONT_ERROR_NOTHING_DEFINED: i32 = 4;
/// All pixels are equal.
pub const SKYFRONT_ERROR_CONSTANT: i32 = 5;
/// No part of the frame has enough pixels to measure its sky.
pub const SKYFRONT_ERROR_NO_SKY: i32 = 6;
/// The pixels show no noise.
pub const SKYFRONT_ERROR_NO_NOISE: i32 = 7;
/// The arithmetic cannot serve a setting.
pub const SKYFRONT_ERROR_ARITHMETIC: i32 = 8;
/// Two settings cannot go together.
pub const SKYFRONT_ERROR_TOGETHER: i32 = 9;
/// The scheme is not moved in slices.
pub const SKYFRONT_ERROR_FRONT: i32 = 10;
/// Other parts of the image have yet to answer.
pub const SKYFRONT_ERROR_WAITING: i32 = 11;
/// The memory of the run was changed between two calls.
pub const SKYFRONT_ERROR_CORRUPTED: i32 = 12;
/// The frame failed to deliver a row.
pub const SKYFRONT_ERROR_FRAME: i32 = 13;
/// A pointer is null or not aligned.
pub const SKYFRONT_ERROR_POINTER: i32 = 14;
/// There is no preset of this number.
pub const SKYFRONT_ERROR_PRESET: i32 = 15;
/// There is no setting of this name, or none with this value.
pub const SKYFRONT_ERROR_SETTING: i32 = 16;
/// The run has not ended yet.
pub const SKYFRONT_ERROR_NOT_DONE: i32 = 17;
/// There is no row or source of this number.
pub const SKYFRONT_ERROR_INDEX: i32 = 18;
/// The parameter table is damaged, or of another version.
pub const SKYFRONT_ERROR_TABLE: i32 = 19;

/// A snapshot was not taken up, and the run that was to take it up has lost its memory.
pub const SKYFRONT_ERROR_NOT_RESTORED: i32 = 20;
/// The frame was changed by others while the run read it.
pub const SKYFRONT_ERROR_FRAME_CHANGED: i32 = 21;

/// Their texts, in the order of the numbers.
const TEXTS: [&CStr; 22] = [
    c"no error",
    c"a parameter is out of its bounds",
    c"the image has an unsupported size",
    c"memory or an array is too short",
    c"no pixel is a finite number",
    c"all pixels are equal",
    c"no part of the frame has enough pixels to measure its sky",
    c"the pixels show no noise",
    c"the arithmetic cannot serve a setting",
    c"two settings cannot go together",
    c"the scheme is not moved in slices",
    c"other parts of the image have yet to answer",
    c"the memory of the run was changed between two calls",
    c"the frame failed to deliver a row",
    c"a pointer is null or not aligned",
    c"there is no preset of this number",
    c"there is no setting of this name, or none with this value",
    c"the run has not ended yet",
    c"there is no row or source of this number",
    c"the parameter table is damaged, or of another version",
    c"the snapshot was not taken up: the run has lost its memory",
    c"the frame was changed while it was worked on",
];

/// What a number says, as a text that stays; "unknown error" for a number that is none.
#[unsafe(no_mangle)]
pub extern "C" fn skyfront_error_text(error: i32) -> *const c_char {
    let known = usize::try_from(error).ok().and_then(|number| TEXTS.get(number));
    known.map_or(c"unknown error", |text| text).as_ptr()
}

/// The number of an error of the core.
pub(crate) fn number<E>(error: &Error<E>) -> i32 {
    match error {
        Error::Parameter { .. } => SKYFRONT_ERROR_PARAMETER,
        Error::Size { .. } => SKYFRONT_ERROR_SIZE,
        Error::Length { .. } => SKYFRONT_ERROR_LENGTH,
        Error::NothingDefined { .. } => SKYFRONT_ERROR_NOTHING_DEFINED,
        Error::Constant { .. } => SKYFRONT_ERROR_CONSTANT,
        Error::NoSky { .. } => SKYFRONT_ERROR_NO_SKY,
        Error::NoNoise { .. } => SKYFRONT_ERROR_NO_NOISE,
        Error::Arithmetic { .. } => SKYFRONT_ERROR_ARITHMETIC,
        Error::Together { .. } => SKYFRONT_ERROR_TOGETHER,
        Error::Front { .. } => SKYFRONT_ERROR_FRONT,
        Error::Waiting => SKYFRONT_ERROR_WAITING,
        Error::Corrupted { .. } => SKYFRONT_ERROR_CORRUPTED,
        Error::FrameChanged => SKYFRONT_ERROR_FRAME_CHANGED,
        Error::NotRestored => SKYFRONT_ERROR_NOT_RESTORED,
        Error::Frame(_) => SKYFRONT_ERROR_FRAME,
    }
}

/// A message in a caller's buffer, cut to its length and closed with a zero byte.
pub(crate) struct Message<'a> {
    pub(crate) buffer: &'a mut [u8],
    pub(crate) length: usize,
}

impl Write for Message<'_> {
    fn write_str(&mut self, text: &str) -> core::fmt::Result {
        // The last byte is the zero's.
        let room = self.buffer.len().saturating_sub(1);
        for (to, byte) in self.buffer.iter_mut().take(room).skip(self.length).zip(text.bytes()) {
            *to = byte;
            self.length = self.length.saturating_add(1);
        }
        if let Some(end) = self.buffer.get_mut(self.length) {
            *end = 0;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_stay_as_they_are_and_have_texts() {
        let text = |number| {
            // SAFETY: the text is a constant that ends with a zero.
            unsafe { CStr::from_ptr(skyfront_error_text(number)) }.to_str()
        };
        // Those of version 1; more may follow.
        for (number, words) in [
            (SKYFRONT_OK, "no error"),
            (SKYFRONT_ERROR_PARAMETER, "out of its bounds"),
            (SKYFRONT_ERROR_LENGTH, "too short"),
            (SKYFRONT_ERROR_NO_NOISE, "no noise"),
            (SKYFRONT_ERROR_FRAME, "deliver a row"),
            (SKYFRONT_ERROR_INDEX, "of this number"),
            (SKYFRONT_ERROR_TABLE, "table"),
            (SKYFRONT_ERROR_NOT_RESTORED, "not taken up"),
            (SKYFRONT_ERROR_FRAME_CHANGED, "was changed while"),
            (-1, "unknown"),
            (TEXTS.len() as i32, "unknown"),
        ] {
            assert!(text(number).is_ok_and(|text| text.contains(words)), "{number}: {words}");
        }
        assert_eq!((SKYFRONT_OK, SKYFRONT_ERROR_LENGTH, SKYFRONT_ERROR_FRAME, SKYFRONT_ERROR_INDEX), (0, 3, 13, 18));
        assert_eq!(TEXTS.len(), 22);
    }

    #[test]
    fn messages_are_cut_and_closed() {
        let mut buffer = [b'x'; 8];
        let mut message = Message { buffer: &mut buffer, length: 0 };
        let _ = write!(message, "{} and {}", 12, 34);
        assert_eq!(&buffer, b"12 and \0");
    }
}
