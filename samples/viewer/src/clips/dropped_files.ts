/** What was dropped: files by path, folders walked, the name of the one folder left out. */
export async function droppedFiles(transfer: DataTransfer): Promise<Map<string, File>> {
  const entries = [...transfer.items].map((item) => item.webkitGetAsEntry()).filter((entry) => entry !== null);
  const files = new Map<string, File>();
  const walk = async (entry: FileSystemEntry, path: string): Promise<void> => {
    if (entry.isFile) {
      const file = await new Promise<File>((resolve, reject) => (entry as FileSystemFileEntry).file(resolve, reject));
      files.set(path, file);
      return;
    }
    const reader = (entry as FileSystemDirectoryEntry).createReader();
    for (;;) {
      const children = await new Promise<FileSystemEntry[]>((resolve, reject) => reader.readEntries(resolve, reject));
      if (children.length === 0) return;
      for (const child of children) await walk(child, path === "" ? child.name : `${path}/${child.name}`);
    }
  };
  for (const entry of entries) await walk(entry, entry.isDirectory ? "" : entry.name);
  return files;
}

/** What was chosen in a file dialog; paths of a folder without the folder's own name. */
export function chosenFiles(list: FileList): Map<string, File> {
  return new Map(
    [...list].map((file) => [file.webkitRelativePath ? file.webkitRelativePath.split("/").slice(1).join("/") : file.name, file]),
  );
}
