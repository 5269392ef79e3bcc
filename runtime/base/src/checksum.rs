//! CRC-32 (IEEE 802.3), eight bytes at a time.

const TABLES: [[u32; 256]; 8] = tables();

const fn tables() -> [[u32; 256]; 8] {
    let mut t = [[0u32; 256]; 8];
    let mut i = 0;
    while i < 256 {
        let mut c = i as u32;
        let mut k = 0;
        while k < 8 {
            c = if c & 1 != 0 { 0xEDB8_8320 ^ (c >> 1) } else { c >> 1 };
            k += 1;
        }
        t[0][i] = c;
        i += 1;
    }
    let mut n = 1;
    while n < 8 {
        let mut i = 0;
        while i < 256 {
            t[n][i] = t[0][(t[n - 1][i] & 0xff) as usize] ^ (t[n - 1][i] >> 8);
            i += 1;
        }
        n += 1;
    }
    t
}

/// CRC-32 (IEEE 802.3) of `bytes`; detects every change within 32 neighbouring bits.
pub fn crc32(bytes: &[u8]) -> u32 {
    crc32_of_pieces([bytes])
}

/// CRC-32 of bytes in several pieces, equal to [`crc32`] of the joined bytes.
pub fn crc32_of_pieces<'a>(pieces: impl IntoIterator<Item = &'a [u8]>) -> u32 {
    !pieces.into_iter().fold(!0, extend_register)
}

/// CRC register after `bytes` are added to register `c`.
fn extend_register(mut c: u32, bytes: &[u8]) -> u32 {
    let (chunks, rest) = bytes.as_chunks::<8>();
    for b in chunks {
        let x = c ^ u32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        c = TABLES[7][(x & 0xff) as usize]
            ^ TABLES[6][(x >> 8 & 0xff) as usize]
            ^ TABLES[5][(x >> 16 & 0xff) as usize]
            ^ TABLES[4][(x >> 24) as usize]
            ^ TABLES[3][b[4] as usize]
            ^ TABLES[2][b[5] as usize]
            ^ TABLES[1][b[6] as usize]
            ^ TABLES[0][b[7] as usize];
    }
    for &b in rest {
        c = TABLES[0][((c ^ u32::from(b)) & 0xff) as usize] ^ (c >> 8);
    }
    c
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gives_the_published_check_value() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
        assert_eq!(crc32(b""), 0);
        assert_eq!(crc32_of_pieces([&b"123"[..], b"", b"456789"]), 0xCBF4_3926);
    }
}
