//! Pages of a Parquet column, refused where they would make the decoder of `parquet` panic.

use parquet::basic::Encoding;
use parquet::column::page::{Page, PageMetadata, PageReader};
use parquet::errors::ParquetError;
use parquet::schema::types::ColumnDescriptor;

/// The pages of one chunk.
pub(crate) struct Checked {
    pages: Box<dyn PageReader>,
    /// The next page, if it was looked at.
    next: Option<Page>,
    has_dictionary: bool,
    /// Whether the column has repetition levels, and definition levels.
    has_levels: [bool; 2],
}

impl Checked {
    pub(crate) fn new(pages: Box<dyn PageReader>, column: &ColumnDescriptor) -> Self {
        let has_levels = [column.max_rep_level() > 0, column.max_def_level() > 0];
        Self { pages, next: None, has_dictionary: false, has_levels }
    }

    fn read(&mut self) -> Result<Option<Page>, ParquetError> {
        let Some(page) = self.pages.get_next_page()? else { return Ok(None) };
        let encoding = page.encoding();
        let is_coded = encoding == Encoding::PLAIN_DICTIONARY || encoding == Encoding::RLE_DICTIONARY;
        let wrong = match &page {
            Page::DictionaryPage { .. } => {
                self.has_dictionary = true;
                None
            }
            _ if is_coded && !self.has_dictionary => Some("a page needs a dictionary that is not there"),
            Page::DataPage { rep_level_encoding, def_level_encoding, .. } => {
                let mut levels = self.has_levels.iter().zip([rep_level_encoding, def_level_encoding]);
                let is_other = levels.any(|(is_used, encoding)| *is_used && *encoding != Encoding::RLE);
                is_other
                    .then_some("the levels of a page are bit-packed, an outdated form: write the file again")
            }
            Page::DataPageV2 { buf, rep_levels_byte_len, def_levels_byte_len, .. } => {
                let levels = u64::from(*rep_levels_byte_len) + u64::from(*def_levels_byte_len);
                (levels > buf.len() as u64).then_some("the levels of a page are longer than the page")
            }
        };
        wrong.map_or(Ok(Some(page)), |wrong| Err(ParquetError::General(wrong.into())))
    }
}

impl Iterator for Checked {
    type Item = Result<Page, ParquetError>;

    fn next(&mut self) -> Option<Self::Item> {
        self.get_next_page().transpose()
    }
}

impl PageReader for Checked {
    fn get_next_page(&mut self) -> Result<Option<Page>, ParquetError> {
        match self.next.take() {
            Some(page) => Ok(Some(page)),
            None => self.read(),
        }
    }

    /// From the page itself: a header alone may lack what its kind promises.
    fn peek_next_page(&mut self) -> Result<Option<PageMetadata>, ParquetError> {
        if self.next.is_none() {
            self.next = self.read()?;
        }
        let counts = |page: &Page| match page {
            Page::DataPage { num_values, .. } => (None, Some(*num_values)),
            Page::DataPageV2 { num_values, num_rows, .. } => (Some(*num_rows), Some(*num_values)),
            Page::DictionaryPage { .. } => (None, None),
        };
        Ok(self.next.as_ref().map(|page| {
            let (rows, levels) = counts(page);
            PageMetadata {
                num_rows: rows.map(|n| n as usize),
                num_levels: levels.map(|n| n as usize),
                is_dict: page.is_dictionary_page(),
            }
        }))
    }

    fn skip_next_page(&mut self) -> Result<(), ParquetError> {
        self.get_next_page().map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use parquet::schema::parser::parse_message_type;
    use parquet::schema::types::SchemaDescriptor;

    use super::*;

    /// Pages of a writer, in order.
    struct Given(Vec<Page>);

    impl Iterator for Given {
        type Item = Result<Page, ParquetError>;

        fn next(&mut self) -> Option<Self::Item> {
            (!self.0.is_empty()).then(|| Ok(self.0.remove(0)))
        }
    }

    impl PageReader for Given {
        fn get_next_page(&mut self) -> Result<Option<Page>, ParquetError> {
            self.next().transpose()
        }

        fn peek_next_page(&mut self) -> Result<Option<PageMetadata>, ParquetError> {
            Ok(None)
        }

        fn skip_next_page(&mut self) -> Result<(), ParquetError> {
            self.get_next_page().map(|_| ())
        }
    }

    fn dictionary() -> Page {
        let encoding = Encoding::PLAIN;
        Page::DictionaryPage { buf: vec![0_u8; 8].into(), num_values: 1, encoding, is_sorted: false }
    }

    fn first(encoding: Encoding, levels: Encoding) -> Page {
        Page::DataPage {
            buf: vec![0_u8; 8].into(),
            num_values: 1,
            encoding,
            def_level_encoding: levels,
            rep_level_encoding: Encoding::PLAIN,
            statistics: None,
        }
    }

    fn second(levels: u32) -> Page {
        Page::DataPageV2 {
            buf: vec![0_u8; 8].into(),
            num_values: 1,
            encoding: Encoding::PLAIN,
            num_nulls: 0,
            num_rows: 1,
            def_levels_byte_len: levels,
            rep_levels_byte_len: 1,
            is_compressed: false,
            statistics: None,
        }
    }

    #[test]
    fn regress_pages_that_would_stop_the_decoder_are_refused() {
        let text = "message rows { optional double x; }";
        let schema = SchemaDescriptor::new(Arc::new(parse_message_type(text).expect("a schema")));
        let pages = |given: Vec<Page>| Checked::new(Box::new(Given(given)), &schema.column(0));
        for refused in [
            first(Encoding::RLE_DICTIONARY, Encoding::RLE),
            first(Encoding::PLAIN, Encoding::DELTA_BINARY_PACKED),
            second(8),
            second(u32::MAX),
        ] {
            let mut read = pages(vec![refused]);
            assert!(read.peek_next_page().is_err());
        }
        // The repetition levels of a column without lists are not read.
        let sound = [dictionary(), first(Encoding::RLE_DICTIONARY, Encoding::RLE), second(7)];
        let mut read = pages(Vec::from(sound));
        let rows = [None, None, Some(1)];
        for (i, rows) in rows.into_iter().enumerate() {
            let page = read.peek_next_page().expect("sound").expect("a page");
            assert_eq!((page.num_rows, page.is_dict), (rows, i == 0));
            assert_eq!(
                read.get_next_page().expect("sound").map(|page| page.is_dictionary_page()),
                Some(i == 0)
            );
        }
        assert!(read.get_next_page().expect("the end").is_none());
    }
}
