"""Stock COLMAP as the peer to beat: its own defaults on our frames, then scale, place and circles."""
