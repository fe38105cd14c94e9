//! The write-ahead log of an SQLite database: pages that were written but not yet moved into it.

use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Result, Seek, SeekFrom};

const HEADER: usize = 32;
const FRAME: usize = 24;

/// For each page, the start of its last committed content. The first frame that does not belong to the log
/// ends it: later frames are those of an older log, or incomplete.
pub(super) fn pages(file: &mut File, page_size: usize) -> Result<HashMap<u32, u64>> {
    let mut committed = HashMap::new();
    let mut header = [0; HEADER];
    file.seek(SeekFrom::Start(0))?;
    if read_all(file, &mut header)? < HEADER {
        return Ok(committed);
    }
    let is_big = match word(&header, 0) {
        0x377f_0682 => false,
        0x377f_0683 => true,
        _ => return Ok(committed),
    };
    let mut sum = checksum(&header[..24], [0, 0], is_big);
    if word(&header, 8) as usize != page_size || sum != [word(&header, 24), word(&header, 28)] {
        return Ok(committed);
    }
    let mut waiting = Vec::new();
    let mut frame = vec![0; FRAME + page_size];
    let mut at = HEADER as u64;
    while read_all(file, &mut frame)? == frame.len() {
        sum = checksum(&frame[..8], sum, is_big);
        sum = checksum(&frame[FRAME..], sum, is_big);
        if frame[8..16] != header[16..24] || sum != [word(&frame, 16), word(&frame, 20)] {
            break;
        }
        waiting.push((word(&frame, 0), at + FRAME as u64));
        // The last frame of a commit states the size of the database.
        if word(&frame, 4) > 0 {
            committed.extend(waiting.drain(..));
        }
        at += frame.len() as u64;
    }
    Ok(committed)
}

fn word(bytes: &[u8], at: usize) -> u32 {
    u32::from_be_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

fn checksum(bytes: &[u8], start: [u32; 2], is_big: bool) -> [u32; 2] {
    let [mut a, mut b] = start;
    for pair in bytes.chunks_exact(8) {
        let at = |i: usize| if is_big { word(pair, i) } else { word(pair, i).swap_bytes() };
        a = a.wrapping_add(at(0)).wrapping_add(b);
        b = b.wrapping_add(at(4)).wrapping_add(a);
    }
    [a, b]
}

fn read_all(file: &mut File, buffer: &mut [u8]) -> Result<usize> {
    let mut filled = 0;
    while filled < buffer.len() {
        match file.read(&mut buffer[filled..])? {
            0 => break,
            n => filled += n,
        }
    }
    Ok(filled)
}
