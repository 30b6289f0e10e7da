"""What several test modules share: examples, toys, a browser, a terminal."""
