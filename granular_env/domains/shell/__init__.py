"""The solid with thin walls: what its pictures have to say."""
