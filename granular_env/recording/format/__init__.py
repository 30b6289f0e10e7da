"""The format of a log, which its recorder and its readers share: header, records, index, digests, schemas of messages."""
