//! The smallest proof that two processors compute alike: 100 powers, bit for bit.

/// CRC-32 of the little-endian bytes of 100 `powf` values between 0 and 1.
#[must_use]
pub fn powers() -> u32 {
    let mut crc = !0u32;
    for i in 1..=100u16 {
        let value = libm::powf(f32::from(i) / 101.0, 0.25 + f32::from(i) / 64.0);
        for byte in value.to_le_bytes() {
            crc ^= u32::from(byte);
            for _ in 0..8 {
                crc = (crc >> 1) ^ (0xEDB8_8320 & (crc & 1).wrapping_neg());
            }
        }
    }
    !crc
}
