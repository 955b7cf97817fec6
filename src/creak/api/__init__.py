"""The public Python interface: thin functions over the layers below; `import creak` offers their names."""
