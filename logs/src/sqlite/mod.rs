//! Tables of an SQLite database, read directly (sqlite.org/fileformat2.html): rows of a table in order, with
//! pages of the write-ahead log in place of older ones. No SQL, no indices, no writing.

mod record;
mod wal;

use std::collections::HashMap;
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use crate::error::{LogError, LogPlace};
use crate::packed;
use record::{DAMAGED, varint};
pub(crate) use record::{Record, Value};

/// Largest depth of a tree: with 100 children a page, far more rows than a file can have.
const MOST_DEEP: usize = 20;

pub(crate) struct Database {
    path: PathBuf,
    file: File,
    wal: Option<File>,
    /// Place of each page in the write-ahead log.
    wal_pages: HashMap<u32, u64>,
    page_size: usize,
    /// Number of bytes of a page for content.
    usable: usize,
    pages: u32,
}

/// The declaration of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Schema {
    pub(crate) name: String,
    root: u32,
    /// Names of the columns, and whether each represents the number of the row.
    columns: Vec<(String, bool)>,
}

impl Schema {
    pub(crate) fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|(column, _)| column == name)
    }
}

impl Database {
    pub(crate) fn open(path: &Path) -> Result<Self, LogError> {
        let mut file = packed::open(path)?;
        let size = file.metadata().map_err(LogError::open(path))?.len();
        let mut header = [0; 100];
        file.read_exact(&mut header).map_err(|_| {
            LogError::damaged(
                path,
                LogPlace::Byte(size),
                "the file ends within its header of 100 bytes",
                DAMAGED,
            )
        })?;
        let page_size = match u16::from_be_bytes([header[16], header[17]]) {
            1 => 65_536,
            other => usize::from(other),
        };
        let usable = page_size.saturating_sub(usize::from(header[20]));
        if !page_size.is_power_of_two() || page_size < 512 || usable < 480 {
            let what = format!("a page of {page_size} bytes");
            return Err(LogError::damaged(path, LogPlace::Byte(16), what, DAMAGED));
        }
        let mut pages = (size / page_size as u64) as u32;
        let mut wal_path = path.as_os_str().to_owned();
        wal_path.push("-wal");
        let mut wal = File::open(&wal_path).ok();
        let mut wal_pages = HashMap::new();
        if let Some(found) = &mut wal {
            wal_pages = wal::pages(found, page_size).map_err(LogError::open(Path::new(&wal_path)))?;
            pages = pages.max(wal_pages.keys().copied().max().unwrap_or(0));
        }
        // The count of pages is valid if it was written together with the last change.
        let stated = u32::from_be_bytes([header[28], header[29], header[30], header[31]]);
        if header[24..28] == header[92..96] && stated > pages {
            let what = format!("the file ends here, with {pages} of its {stated} pages");
            return Err(LogError::damaged(path, LogPlace::Byte(size), what, DAMAGED));
        }
        Ok(Self { path: path.to_owned(), file, wal, wal_pages, page_size, usable, pages })
    }

    pub(crate) fn tables(&mut self) -> Result<Vec<Schema>, LogError> {
        let mut found = Vec::new();
        self.scan(1, &mut |record| {
            let values = record.values()?;
            let [Value::Text(kind), Value::Text(name), _, Value::Int(root), Value::Text(sql)] =
                values.as_slice()
            else {
                return Ok(());
            };
            if *kind == b"table" {
                found.push(Schema {
                    name: String::from_utf8_lossy(name).into_owned(),
                    root: u32::try_from(*root).unwrap_or(0),
                    columns: columns(&String::from_utf8_lossy(sql)),
                });
            }
            Ok(())
        })?;
        Ok(found)
    }

    /// Passes on every row of a table, in order.
    pub(crate) fn rows(
        &mut self,
        table: &Schema,
        row: &mut dyn FnMut(&[Value<'_>]) -> Result<(), LogError>,
    ) -> Result<(), LogError> {
        let is_number: Vec<bool> = table.columns.iter().map(|(_, is)| *is).collect();
        self.scan(table.root, &mut |record| {
            let mut values = record.values()?;
            for (value, _) in
                values.iter_mut().zip(&is_number).filter(|(value, is)| **is && **value == Value::Null)
            {
                *value = Value::Int(record.number);
            }
            row(&values)
        })
    }

    /// Walks a tree from its root.
    fn scan(
        &mut self,
        root: u32,
        row: &mut dyn FnMut(&Record<'_>) -> Result<(), LogError>,
    ) -> Result<(), LogError> {
        // Pages to visit, the next one last, each with its depth.
        let mut ahead = vec![(root, 0_usize)];
        let mut visited = 0_u32;
        let mut payload = Vec::new();
        while let Some((number, depth)) = ahead.pop() {
            visited += 1;
            if visited > self.pages || depth > MOST_DEEP {
                return Err(self.damaged(number, 0, "the pages of a table refer to each other in a loop"));
            }
            let page = self.page(number)?;
            let start = if number == 1 { 100 } else { 0 };
            let kind = page[start];
            let head = match kind {
                0x0d => 8,
                0x05 => 12,
                other => {
                    return Err(self.damaged(
                        number,
                        start,
                        format!("a page of kind {other:#04x} in a table"),
                    ));
                }
            };
            let cells = usize::from(u16::from_be_bytes([page[start + 3], page[start + 4]]));
            let pointers = page
                .get(start + head..start + head + 2 * cells)
                .ok_or_else(|| self.damaged(number, start + 3, format!("{cells} cells in a page")))?;
            let offsets: Vec<usize> = pointers
                .chunks_exact(2)
                .map(|pair| usize::from(u16::from_be_bytes([pair[0], pair[1]])))
                .collect();
            if kind == 0x05 {
                ahead.push((be_u32(&page, start + 8).unwrap_or(0), depth + 1));
                for offset in offsets.iter().rev() {
                    let child = be_u32(&page, *offset)
                        .ok_or_else(|| self.damaged(number, *offset, "a cell lies outside its page"))?;
                    ahead.push((child, depth + 1));
                }
                continue;
            }
            for offset in offsets {
                let key = self.payload(&page, number, offset, &mut payload)?;
                let place = u64::from(number - 1) * self.page_size as u64 + offset as u64;
                row(&Record { path: &self.path, place, number: key, bytes: &payload })?;
            }
        }
        Ok(())
    }

    /// Collects the content of a cell, including its overflow pages. Returns the number of the row.
    fn payload(
        &mut self,
        page: &[u8],
        number: u32,
        offset: usize,
        into: &mut Vec<u8>,
    ) -> Result<i64, LogError> {
        into.clear();
        let outside = || self.damaged(number, offset, "a cell lies outside its page");
        let mut at = offset;
        let length = varint(page, &mut at).ok_or_else(outside)?;
        let key = varint(page, &mut at).ok_or_else(outside)?;
        let length = usize::try_from(length).map_err(|_| outside())?;
        // A length beyond the file would only reserve memory.
        if length as u64 > u64::from(self.pages) * self.page_size as u64 {
            return Err(self.damaged(number, offset, format!("a row of {length} bytes")));
        }
        let most = self.usable - 35;
        let local = if length <= most {
            length
        } else {
            let least = (self.usable - 12) * 32 / 255 - 23;
            let even = least + (length - least) % (self.usable - 4);
            if even <= most { even } else { least }
        };
        into.extend_from_slice(page.get(at..at + local).ok_or_else(outside)?);
        at += local;
        let mut next = if local < length { be_u32(page, at).ok_or_else(outside)? } else { 0 };
        while into.len() < length {
            let page = self.page(next)?;
            let count = (length - into.len()).min(self.usable - 4);
            into.extend_from_slice(&page[4..4 + count]);
            next = be_u32(&page, 0).unwrap_or(0);
        }
        Ok(key)
    }

    fn page(&mut self, number: u32) -> Result<Vec<u8>, LogError> {
        if number == 0 || number > self.pages {
            let what = format!("page {number} is asked for, and there are {}", self.pages);
            let end = u64::from(self.pages) * self.page_size as u64;
            return Err(LogError::damaged(&self.path, LogPlace::Byte(end), what, DAMAGED));
        }
        let mut page = vec![0; self.page_size];
        let (file, at) = match (&mut self.wal, self.wal_pages.get(&number)) {
            (Some(wal), Some(at)) => (wal, *at),
            _ => (&mut self.file, u64::from(number - 1) * self.page_size as u64),
        };
        file.seek(SeekFrom::Start(at))
            .and_then(|_| file.read_exact(&mut page))
            .map_err(LogError::open(&self.path))?;
        Ok(page)
    }

    fn damaged(&self, page: u32, offset: usize, what: impl Into<String>) -> LogError {
        let byte = u64::from(page.saturating_sub(1)) * self.page_size as u64 + offset as u64;
        LogError::damaged(&self.path, LogPlace::Byte(byte), what, DAMAGED)
    }
}

fn be_u32(bytes: &[u8], at: usize) -> Option<u32> {
    let four = bytes.get(at..at.checked_add(4)?)?;
    Some(u32::from_be_bytes([four[0], four[1], four[2], four[3]]))
}

/// Names of the columns of a `CREATE TABLE`, and whether each is the number of the row.
fn columns(sql: &str) -> Vec<(String, bool)> {
    let inner = sql.split_once('(').map_or("", |(_, rest)| rest);
    let mut depth = 0;
    let mut parts = vec![String::new()];
    for c in inner.chars() {
        match c {
            '(' => depth += 1,
            ')' if depth == 0 => break,
            ')' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(String::new());
                continue;
            }
            _ => {}
        }
        if let Some(part) = parts.last_mut() {
            part.push(c);
        }
    }
    let named = parts.iter().filter_map(|part| {
        let name = part.split_whitespace().next()?.trim_matches(['"', '`', '[', ']', '\'']);
        let upper = part.to_ascii_uppercase();
        Some((name.to_owned(), upper.contains("INTEGER PRIMARY KEY")))
    });
    named.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truth_columns_are_named_by_their_declaration() {
        let sql = "CREATE TABLE m(id INTEGER PRIMARY KEY,topic_id INTEGER, \"data\" BLOB DEFAULT (1, 2))";
        let found = columns(sql);
        assert_eq!(found, [("id".into(), true), ("topic_id".into(), false), ("data".into(), false)]);
    }
}
