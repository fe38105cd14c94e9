//! Bags whose files were compressed as a whole, as `ros2 bag record --compression-mode file` writes them.

use std::fs::File;
use std::io::{BufReader, Read, Seek, Write};
use std::path::Path;

use feeler_problem::sort::{Sort, ZSTD, sort_of};
use zstd::stream::read::Decoder;

use crate::error::{LogError, LogPlace};

const DAMAGED: &str = "the file is damaged or cut off: copy it again, or record again";
/// Largest ratio of unpacked to packed size, and the size that any file may have. Logs that hardly change
/// reach hundreds.
const GROWTH: u64 = 1 << 12;
const LEAST_BYTES: u64 = 1 << 28;
/// The same of arrays and tables, whose numbers are held in memory.
const GROWTH_OF_NUMBERS: u64 = 1 << 8;
/// Bytes that are unpacked at a time.
const BLOCK: usize = 1 << 20;
/// First bytes that tell the sort of a file.
const START: u64 = 512;

/// The most bytes that the numbers of an array or table of `size` packed bytes may take.
pub(crate) fn most_bytes(size: u64) -> u64 {
    size.saturating_mul(GROWTH_OF_NUMBERS).max(LEAST_BYTES)
}

/// The first bytes of a file, and the sort that they tell. The sort of a packed bag is that of its content.
pub(crate) fn start(path: &Path) -> Result<(Vec<u8>, Option<Sort>), LogError> {
    let own = plain_start(path)?;
    if sort_of(&own) == Some(ZSTD) {
        let mut inside = Vec::new();
        // A damaged file is refused where it is read.
        let unpacked = decoder(path)?.take(START).read_to_end(&mut inside);
        let sort = sort_of(&inside).filter(|sort| unpacked.is_ok() && is_bag(*sort));
        if sort.is_some() {
            return Ok((inside, sort));
        }
    }
    let sort = sort_of(&own);
    Ok((own, sort))
}

/// The bytes of a bag: of its file, or of an unnamed one into which that was unpacked.
pub(crate) fn open(path: &Path) -> Result<File, LogError> {
    if sort_of(&plain_start(path)?) != Some(ZSTD) {
        return File::open(path).map_err(LogError::open(path));
    }
    let size = std::fs::metadata(path).map_err(LogError::open(path))?.len();
    let most = size.saturating_mul(GROWTH).max(LEAST_BYTES);
    let no_room = |error: std::io::Error| {
        let remedy = "unpack it by `zstd -d FILE` where there is room, and name what comes out";
        LogError::other(
            path,
            format!("it is compressed by zstd, and cannot be unpacked here: {error}"),
            remedy,
        )
    };
    let mut whole = tempfile::tempfile().map_err(no_room)?;
    let mut packed = decoder(path)?;
    let (mut block, mut written) = (vec![0; BLOCK], 0);
    loop {
        let read = match packed.read(&mut block) {
            Ok(0) => break,
            Ok(read) => read,
            Err(error) => {
                let at = packed.get_mut().stream_position().unwrap_or(size);
                let what = format!("at or before this byte: its compression by zstd is damaged: {error}");
                return Err(LogError::damaged(path, LogPlace::Byte(at), what, DAMAGED));
            }
        };
        written += read as u64;
        if written > most {
            let what = format!("its {size} bytes unpack to more than {most}");
            return Err(LogError::damaged(path, LogPlace::Byte(size), what, DAMAGED));
        }
        whole.write_all(&block[..read]).map_err(no_room)?;
    }
    whole.rewind().map_err(no_room)?;
    Ok(whole)
}

fn is_bag(sort: Sort) -> bool {
    sort == feeler_problem::sort::MCAP || sort == feeler_problem::sort::SQLITE
}

fn plain_start(path: &Path) -> Result<Vec<u8>, LogError> {
    let mut start = Vec::new();
    let file = File::open(path).map_err(LogError::open(path))?;
    file.take(START).read_to_end(&mut start).map_err(LogError::open(path))?;
    Ok(start)
}

fn decoder(path: &Path) -> Result<Decoder<'static, BufReader<File>>, LogError> {
    let file = File::open(path).map_err(LogError::open(path))?;
    Decoder::new(file).map_err(LogError::open(path))
}
