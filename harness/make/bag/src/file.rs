//! MCAP files of rosbag2.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use mcap::read::ChunkReader;
use mcap::records::{ChunkHeader, Record};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, parse_record};

use crate::{Bag, BagError};

/// Maximum size of a record, and of a chunk after decompression, bytes.
const RECORD: usize = 256 << 20;
/// The encoding of messages in bags of ROS 2.
const CDR: &str = "cdr";

/// Reads a bag: an MCAP file, or the folder of a bag with MCAP files.
///
/// # Errors
/// Returns an error if the bag can't be read, is in another storage format, or has a message that is not of the type of its topic.
pub fn read(path: &Path) -> Result<Bag, BagError> {
    let mut bag = Bag::default();
    for file in files(path)? {
        Reader::new(&file, &mut bag).read()?;
    }
    Ok(bag)
}

/// The MCAP files of a bag, in the order of their names, which is that of their times.
fn files(path: &Path) -> Result<Vec<PathBuf>, BagError> {
    let unreadable = |source| BagError::Read { path: path.to_owned(), source };
    if !std::fs::metadata(path).map_err(unreadable)?.is_dir() {
        return Ok(vec![path.to_owned()]);
    }
    let mut files = Vec::new();
    let mut sqlite = false;
    for entry in std::fs::read_dir(path).map_err(unreadable)? {
        let file = entry.map_err(unreadable)?.path();
        match file.extension().and_then(|e| e.to_str()) {
            Some("mcap") => files.push(file),
            Some("db3") => sqlite = true,
            _ => {}
        }
    }
    if files.is_empty() {
        let problem =
            if sqlite { SQLITE } else { "contains no MCAP file; give an MCAP file or the folder of a bag" };
        return Err(BagError::Format { path: path.to_owned(), problem: problem.to_owned() });
    }
    files.sort();
    Ok(files)
}

const SQLITE: &str = "the storage format is SQLite; convert the bag to MCAP with `ros2 bag convert`, or with \
                      `rosbags-convert --dst-storage mcap` (pip install rosbags)";

/// A channel whose messages are read.
struct Channel {
    topic: String,
    kind: String,
}

/// One file while it is read.
struct Reader<'a> {
    path: &'a Path,
    bag: &'a mut Bag,
    schemas: BTreeMap<u16, String>,
    channels: BTreeMap<u16, Channel>,
}

impl<'a> Reader<'a> {
    fn new(path: &'a Path, bag: &'a mut Bag) -> Self {
        Self { path, bag, schemas: BTreeMap::new(), channels: BTreeMap::new() }
    }

    fn format(&self, problem: impl Into<String>) -> BagError {
        BagError::Format { path: self.path.to_owned(), problem: problem.into() }
    }

    fn damaged(&self, e: &McapError) -> BagError {
        self.format(match e {
            McapError::BadMagic => "is not an MCAP file".to_owned(),
            McapError::UnexpectedEof => {
                "is truncated, e.g. after a crash; repair it with `mcap recover` or `ros2 bag reindex`"
                    .to_owned()
            }
            e => format!("damaged MCAP file: {}", vb_files::one_line(&e.to_string())),
        })
    }

    fn read(&mut self) -> Result<(), BagError> {
        let unreadable = |source| BagError::Read { path: self.path.to_owned(), source };
        let mut file = File::open(self.path).map_err(unreadable)?;
        let mut start = [0; 16];
        let length = file.read(&mut start).map_err(unreadable)?;
        if start[..length].starts_with(b"SQLite format 3") {
            return Err(self.format(SQLITE));
        }
        if start[..length].starts_with(b"#ROSBAG") {
            let problem =
                "is a ROS 1 bag; convert it with `rosbags-convert --dst-storage mcap` (pip install rosbags)";
            return Err(self.format(problem));
        }
        let options = LinearReaderOptions::default()
            .with_emit_chunks(true)
            .with_validate_data_section_crc(true)
            .with_record_length_limit(RECORD);
        let mut reader = LinearReader::new_with_options(options);
        reader.insert(length).copy_from_slice(&start[..length]);
        reader.notify_read(length);
        while let Some(event) = reader.next_event() {
            match event.map_err(|e| self.damaged(&e))? {
                LinearReadEvent::ReadRequest(need) => {
                    let read = file.read(reader.insert(need)).map_err(unreadable)?;
                    reader.notify_read(read);
                }
                LinearReadEvent::Record { data, opcode } => {
                    let record = parse_record(opcode, data).map_err(|e| self.damaged(&e))?;
                    self.record(record)?;
                }
            }
        }
        Ok(())
    }

    fn record(&mut self, record: Record<'_>) -> Result<(), BagError> {
        match record {
            Record::Schema { header, .. } => {
                self.schemas.insert(header.id, header.name);
            }
            Record::Channel(channel) if channel.message_encoding == CDR => {
                let kind = self.schemas.get(&channel.schema_id).cloned().unwrap_or_default();
                self.channels.insert(channel.id, Channel { topic: channel.topic, kind });
            }
            Record::Message { header, data } => {
                if let Some(Channel { topic, kind }) = self.channels.get(&header.channel_id) {
                    let time = i64::try_from(header.log_time).map_err(|_| {
                        self.format(format!("a message on {topic} has the time {} ns", header.log_time))
                    })?;
                    self.bag.add(self.path, topic, kind, time, &data)?;
                }
            }
            Record::Chunk { header, data } => self.chunk(header, &data)?,
            _ => {}
        }
        Ok(())
    }

    /// Reads the records of a chunk.
    fn chunk(&mut self, header: ChunkHeader, data: &[u8]) -> Result<(), BagError> {
        if header.uncompressed_size > RECORD as u64 {
            let (size, most) = (header.uncompressed_size, RECORD);
            return Err(self.format(format!(
                "a chunk has {size} bytes after decompression; at most {most} are allowed"
            )));
        }
        let plain;
        let (header, data) = match header.compression.as_str() {
            "" => (header, data),
            "zstd" => {
                plain = zstd(data, header.uncompressed_size)
                    .map_err(|e| self.format(format!("a chunk: zstd: {e}")))?;
                let compressed_size = plain.len() as u64;
                (ChunkHeader { compression: String::new(), compressed_size, ..header }, &plain[..])
            }
            other => {
                let problem = format!(
                    "chunks are compressed with {other}; convert the bag to zstd or to no compression with `ros2 bag convert` or \
                     `mcap compress --compression zstd`"
                );
                return Err(self.format(vb_files::one_line(&problem)));
            }
        };
        let records = ChunkReader::new(header, data).map_err(|e| self.damaged(&e))?;
        for record in records {
            let record = record.map_err(|e| self.damaged(&e))?;
            if matches!(record, Record::Chunk { .. }) {
                return Err(self.format("damaged MCAP file: a chunk within a chunk"));
            }
            self.record(record)?;
        }
        Ok(())
    }
}

/// Decompresses `size` bytes.
fn zstd(data: &[u8], size: u64) -> Result<Vec<u8>, String> {
    let decoder = ruzstd::decoding::StreamingDecoder::new(data).map_err(|e| e.to_string())?;
    let mut plain = Vec::new();
    decoder.take(size).read_to_end(&mut plain).map_err(|e| e.to_string())?;
    if plain.len() as u64 == size { Ok(plain) } else { Err(format!("{} of {size} bytes", plain.len())) }
}
