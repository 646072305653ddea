#pragma once

#include "CoreMinimal.h"
#include "UObject/Object.h"

#include <memory>

#include "FaceBakerAsset.generated.h"

class UAssetImportData;
namespace facebaker {
class Model;
}

/** An .fbk archive as an asset, as the importer makes it. Components that pose it share one loaded face. */
UCLASS(BlueprintType)
class FACEBAKER_API UFaceBakerAsset : public UObject {
  GENERATED_BODY()

 public:
  /** The file's bytes. */
  UPROPERTY()
  TArray<uint8> Archive;

#if WITH_EDITORONLY_DATA
  /** The file it was imported from, as a path from the project where it lies there; no part of cooked assets. */
  UPROPERTY(VisibleAnywhere, Instanced, Category = "FaceBaker")
  TObjectPtr<UAssetImportData> AssetImportData;
#endif

  /** The face, loaded by the first who asks and freed with the last who holds it; null, and a log message, if the
   * archive is damaged. Game thread only. */
  std::shared_ptr<const facebaker::Model> Load();
  /** What is wrong with an archive; empty if nothing is. */
  static FString WhatIsWrong(const TArray<uint8>& Bytes);

 private:
  std::weak_ptr<const facebaker::Model> Loaded;
};
